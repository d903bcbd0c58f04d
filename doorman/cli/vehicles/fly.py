"""`doorman fly`: the mission on the vehicle."""

from __future__ import annotations

from doorman.cli.command import VEHICLE, command
from doorman.cli.options import FeedPort, Json, Settings, Source, Vehicle
from doorman.cli.vehicles import fly_options as options


@command(VEHICLE)
def fly(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    out: options.Recording = None,
    duration: options.Duration = None,
    dry_run: options.DryRun = False,
    write_parameters: options.WriteParameters = False,
    write_eeprom: options.WriteEeprom = False,
    feed: FeedPort = None,
    yes: options.Unasked = False,
    as_json: Json = False,
    pixhawk: options.Pixhawk = None,
    servos: options.Servos = None,
    mocap: options.Mocap = None,
    link: options.LinkKeys = None,
    setpoints: options.Setpoints = None,
    local_frame: options.LocalFrame = None,
    signing_key: options.SigningKey = None,
    servo_ids: options.ServoIds = None,
    servo_directions: options.ServoDirections = None,
    servo_zeros: options.ServoZeros = None,
    object_name: options.ObjectName = None,
    mocap_rate: options.MocapRate = None,
) -> int:
    """Fly the mission on the vehicle: checklist, take-off, door, landing.

    The vehicle file contains links and calibration. Options under its heading override its keys.

    Ctrl-C ends the mission and flies back to the hover point; a second Ctrl-C lands at once. SIGTERM flies back and lands.
    The radio's mode switch overrides everything. The exit status is 0 if the mission reached its end and the vehicle has
    landed, 1 if not, 2 if the input cannot be used or a link cannot be opened.
    """
    from doorman.cli.values import parse_overrides, real_numbers, whole_numbers
    from doorman.cli.vehicles.flight import fly_mission

    frame = real_numbers(local_frame, "--local-frame", 4)
    given = {
        "pixhawk.connection": pixhawk, "servos.port": servos, "mocap.connection": mocap,
        "pixhawk.setpoints": setpoints, "pixhawk.signing_key": signing_key,
        "pixhawk.local_frame": frame and {"origin": frame[:3], "yaw": frame[3]},
        "servos.ids": whole_numbers(servo_ids, "--servo-ids"),
        "servos.directions": whole_numbers(servo_directions, "--servo-directions"),
        "servos.zero_positions": whole_numbers(servo_zeros, "--servo-zeros"),
        "mocap.object_name": object_name, "mocap.rate": mocap_rate,
        "pixhawk.write_parameters": write_parameters or None, "servos.write_eeprom": write_eeprom or None,
    }  # fmt: skip
    links = {key: value for key, value in given.items() if value is not None} | parse_overrides(link, "--link")
    return fly_mission(
        scenario, settings, vehicle, links, out, duration, dry_run, yes, "json" if as_json else "words", feed
    )
