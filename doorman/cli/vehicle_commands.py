"""`doorman rig` and `doorman fly`: their arguments and their help."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli import panels
from doorman.cli.arguments import FeedPort, Settings, Source


class AutopilotKind(StrEnum):
    """Who flies the rig's vehicle."""

    PX4 = "px4"
    ARDUPILOT = "ardupilot"
    PX4_SITL = "px4-sitl"
    ARDUPILOT_SITL = "ardupilot-sitl"


class SetpointKind(StrEnum):
    """What is sent to the autopilot."""

    ATTITUDE = "attitude"
    POSITION = "position"


_Ids = Annotated[str | None, typer.Option(metavar="1,2,3", help="Servos from base to tip, then the gripper's.")]
_Signs = Annotated[str | None, typer.Option(metavar="1,-1", help="Directions of the servos.", show_default="all 1")]
_Zeros = Annotated[
    str | None, typer.Option(metavar="2048", help="Ticks of the servos at the joints' zeros.", show_default="all 2048")
]


def add_vehicle_commands(app: typer.Typer, leave: Callable[[Callable[[], int]], None]) -> None:
    """Register both commands.

    Args:
        app: The application.
        leave: Runs a command and leaves with its exit status.
    """
    app.command("rig", rich_help_panel=panels.VEHICLE)(_rig_command(leave))
    app.command("fly", rich_help_panel=panels.VEHICLE)(_fly_command(leave))


def _rig_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
    def rig(
        scenario: Source = "paper",
        settings: Settings = None,
        autopilot: Annotated[
            AutopilotKind,
            typer.Option(help="Whose rules it follows; px4-sitl, ardupilot-sitl: their own code, which you start."),
        ] = AutopilotKind.PX4,
        pixhawk_port: Annotated[int, typer.Option(help="UDP port on loopback that the autopilot sends to.")] = 14540,
        mocap_port: Annotated[int, typer.Option(help="UDP port that the cameras send to; 0: no cameras.")] = 51001,
        out: Annotated[Path | None, typer.Option(metavar="FILE", help="Record the truth, as MCAP.")] = None,
        seed: Annotated[int, typer.Option(min=0, help="Of noise.")] = 0,
        fly: Annotated[
            bool, typer.Option("--fly", help="Fly the mission against it, judge the flight, and leave.")
        ] = False,
        as_json: Annotated[
            bool, typer.Option("--json", help="Print the links, or with --fly the summary, as JSON; words to stderr.")
        ] = False,
    ) -> None:
        """Emulate autopilot, servos and cameras around one simulated vehicle and door.

        They speak the protocols of the real ones, on loopback and on a pseudo-terminal. The command prints what to type into
        another terminal to fly the mission against it, and runs until Ctrl-C. With --fly it does both; the exit status is then
        0 only if the door was opened, nothing was touched and the vehicle has landed.
        """

        def command() -> int:
            if fly:
                if autopilot in (AutopilotKind.PX4_SITL, AutopilotKind.ARDUPILOT_SITL):
                    raise typer.BadParameter(
                        f"{autopilot.value} is started by hand: run the rig without --fly", param_hint="--fly"
                    )
                from doorman.cli.rig_demo import fly_the_rig

                return fly_the_rig(scenario, settings or [], autopilot.value, out, seed, as_json)
            from doorman.cli.rig import run_rig

            return run_rig(
                scenario, settings or [], autopilot.value, pixhawk_port, mocap_port, out, seed=seed, as_json=as_json
            )

        leave(command)

    return rig


def _fly_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
    def fly(
        pixhawk: Annotated[str, typer.Option(metavar="LINK", help="Autopilot: udp:14540, serial:/dev/ttyACM0:921600.")],
        servos: Annotated[str, typer.Option(metavar="DEVICE", help="Serial device of the arm's servos.")],
        scenario: Source = "paper",
        settings: Settings = None,
        mocap: Annotated[
            str | None,
            typer.Option(
                metavar="LINK",
                help="Cameras: udp:51001 for Vicon Tracker's stream; vicon:HOST, optitrack:HOST, qualisys:HOST, vrpn:HOST.",
                show_default="the autopilot's estimate",
            ),
        ] = None,
        local_frame: Annotated[
            str | None,
            typer.Option(
                metavar="X,Y,Z,YAW",
                help="Origin [m] of the autopilot's local frame, and where its north points [rad], in the scenario's world.",
                show_default="0,0,0,0",
            ),
        ] = None,
        setpoints: Annotated[SetpointKind, typer.Option(help="What the autopilot gets.")] = SetpointKind.ATTITUDE,
        object_name: Annotated[str, typer.Option(metavar="NAME", help="Of the vehicle in the stream.")] = "vehicle",
        mocap_rate: Annotated[float, typer.Option(metavar="HZ", help="Frames per second of the cameras.")] = 100.0,
        servo_ids: _Ids = None,
        servo_directions: _Signs = None,
        servo_zeros: _Zeros = None,
        link: Annotated[
            list[str] | None,
            typer.Option(
                metavar="KEY=VALUE",
                help="Any other setting of a link, such as pixhawk.vehicle_system=2 or servos.baud_rate=57600; may be repeated.",
            ),
        ] = None,
        out: Annotated[
            Path | None, typer.Option(metavar="FILE", help="Recording, as MCAP.", show_default="a new one under runs")
        ] = None,
        duration: Annotated[
            float | None,
            typer.Option(metavar="SECONDS", help="End the mission then, as flown.", show_default="its own"),
        ] = None,
        dry_run: Annotated[
            bool, typer.Option("--dry-run", help="Listen to the links, send nothing at all, and check what that tells.")
        ] = False,
        write_parameters: Annotated[
            bool,
            typer.Option(
                "--write-parameters",
                help="Write the autopilot's parameters that the checklist finds wrong, and do not fly; then reboot it.",
            ),
        ] = False,
        write_eeprom: Annotated[
            bool, typer.Option("--write-eeprom", help="Change settings of the servos that are not as they should be.")
        ] = False,
        signing_key: Annotated[
            Path | None,
            typer.Option(
                metavar="FILE",
                help="MAVLink signing key: 32 bytes or 64 hexadecimal digits.",
                show_default="no signing",
            ),
        ] = None,
        feed: FeedPort = None,
        yes: Annotated[bool, typer.Option("--yes", help="Do not ask before arming.")] = False,
        as_json: Annotated[
            bool, typer.Option("--json", help="Print checklist and result as JSON; words to stderr.")
        ] = False,
    ) -> None:
        """Fly the mission on the vehicle: checklist, take-off, door, landing.

        Ctrl-C once gives the mission up and flies back to the hover point, twice lands at once. SIGTERM flies back and lands. The
        radio's mode switch always wins. The exit status is 0 if the mission was flown to its end and the vehicle has landed, 1
        if not, 2 if the input cannot be used or a link cannot be opened.
        """

        def command() -> int:
            from doorman.cli.fly import Wiring, fly_mission
            from doorman.cli.numbers import real_numbers, whole_numbers
            from doorman.cli.overrides import parse_overrides

            wiring = Wiring(
                pixhawk, servos, mocap, setpoints.value, object_name, mocap_rate,
                whole_numbers(servo_ids, "--servo-ids"), whole_numbers(servo_directions, "--servo-directions"),
                whole_numbers(servo_zeros, "--servo-zeros"), signing_key, write_parameters,
                write_eeprom, parse_overrides(link or (), "--link"), real_numbers(local_frame, "--local-frame", 4),
                feed,
            )  # fmt: skip
            return fly_mission(
                scenario, settings or [], wiring, out, duration, dry_run, yes, "json" if as_json else "words"
            )

        leave(command)

    return fly
