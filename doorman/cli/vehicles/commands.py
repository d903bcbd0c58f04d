"""`doorman rig` and `doorman fly`: their arguments and their help."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import FeedPort, Settings, Source, Vehicle
from doorman.cli.command import VEHICLE, command
from doorman.cli.terminal.application import app
from doorman.cli.vehicles import fly_options as options


class AutopilotKind(StrEnum):
    """Who flies the rig's vehicle."""

    PX4 = "px4"
    ARDUPILOT = "ardupilot"
    PX4_SITL = "px4-sitl"
    ARDUPILOT_SITL = "ardupilot-sitl"


class Motors(StrEnum):
    """What the rig's motors make of their signal."""

    LINEAR = "linear"
    QUADRATIC = "quadratic"


@command(app, VEHICLE)
def rig(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    autopilot: Annotated[
        AutopilotKind,
        typer.Option(help="Autopilot to emulate; for px4-sitl and ardupilot-sitl you start the autopilot's own code."),
    ] = AutopilotKind.PX4,
    motors: Annotated[
        Motors,
        typer.Option(
            help="linear: the autopilot linearises the motors; quadratic: thrust is the signal squared, 40 ms late."
        ),
    ] = Motors.LINEAR,
    pixhawk_port: Annotated[
        int | None,
        typer.Option(help="UDP port on loopback for the autopilot.", show_default="the vehicle file's, or 14540"),
    ] = None,
    mocap_port: Annotated[
        int | None,
        typer.Option(help="UDP port for the cameras; 0: no cameras.", show_default="the vehicle file's, or 51001"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="MCAP file for the ground truth; with --fly also a folder for truth and flight."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the noise.")] = 0,
    fly: Annotated[
        bool, typer.Option("--fly", help="Fly the mission against the rig, judge the flight, and exit.")
    ] = False,
    judge: Annotated[
        bool,
        typer.Option("--judge", help="After Ctrl-C, judge by the truth what was flown against the rig."),
    ] = False,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Print links, and with --fly or --judge figures, as JSON; messages to stderr."),
    ] = False,
) -> int:
    """Emulate autopilot, servos and cameras around one simulated vehicle and door.

    The emulators use the protocols of the real devices, on loopback and on a pseudo-terminal. The command prints the command
    that flies the mission from another terminal, and runs until Ctrl-C. With --fly it also flies the mission; with --judge
    it judges what others fly, behind an autopilot's own code, too. The exit status is then 0 only if the door is open,
    without a collision, and the vehicle has landed.

    With --vehicle, servos and object have the mounting of the vehicle file, so that a dry run shows whether everything
    matches. If a link of the file is on loopback, or a path outside /dev, the rig creates it there. The printed command has
    options for all other links.
    """
    if fly:
        if judge:
            raise typer.BadParameter("--fly judges the flight by itself", param_hint="--judge")
        if autopilot in (AutopilotKind.PX4_SITL, AutopilotKind.ARDUPILOT_SITL):
            raise typer.BadParameter(
                f"you start {autopilot.value} yourself: run the rig without --fly", param_hint="--fly"
            )
        from doorman.cli.vehicles.rig_demo import fly_the_rig

        return fly_the_rig(scenario, settings or [], autopilot.value, out, seed, as_json, vehicle, motors.value)
    from doorman.cli.vehicles.rig import run_rig

    return run_rig(
        scenario, settings or [], autopilot.value, pixhawk_port, mocap_port, out, seed=seed, as_json=as_json,
        vehicle=vehicle, motors=motors.value, judges=judge,
    )  # fmt: skip


@command(app, VEHICLE)
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
    as_json: options.AsJson = False,
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
    from doorman.cli.overrides import parse_overrides
    from doorman.cli.terminal.numbers import real_numbers, whole_numbers
    from doorman.cli.vehicles.fly import fly_mission

    frame = real_numbers(local_frame, "--local-frame", 4)
    given = {
        "pixhawk.connection": pixhawk, "servos.port": servos, "mocap.connection": mocap,
        "pixhawk.setpoints": setpoints and setpoints.value, "pixhawk.signing_key": signing_key,
        "pixhawk.local_frame": frame and {"origin": frame[:3], "yaw": frame[3]},
        "servos.ids": whole_numbers(servo_ids, "--servo-ids"),
        "servos.directions": whole_numbers(servo_directions, "--servo-directions"),
        "servos.zero_positions": whole_numbers(servo_zeros, "--servo-zeros"),
        "mocap.object_name": object_name, "mocap.rate": mocap_rate,
        "pixhawk.write_parameters": write_parameters or None, "servos.write_eeprom": write_eeprom or None,
    }  # fmt: skip
    links = {key: value for key, value in given.items() if value is not None}
    links |= parse_overrides(link or (), "--link")
    return fly_mission(
        scenario,
        settings or [],
        vehicle,
        links,
        out,
        duration,
        dry_run,
        yes,
        "json" if as_json else "words",
        feed,
    )
