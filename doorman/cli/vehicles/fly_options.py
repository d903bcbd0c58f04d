"""Options of `doorman fly`: how its command line names them, and their help."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class SetpointKind(StrEnum):
    """What is sent to the autopilot."""

    ATTITUDE = "attitude"
    POSITION = "position"


_KEYS = "Instead of keys of the vehicle file"
"""Heading of the options that a vehicle file makes needless."""
_SERVOS = "from base to tip, then the gripper's"


def _named(context: typer.Context, parameter: typer.CallbackParam, value: str | None) -> str | None:
    """A link that the command line names, or leaves to a vehicle file."""
    if value is None and context.params.get("vehicle") is None and not context.resilient_parsing:
        raise typer.BadParameter("A link is missing: give this option or --vehicle.", param_hint=parameter.opts[0])
    return value


Recording = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Recording, as MCAP.", show_default="a new one under runs")
]
Duration = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", help="End the mission after this time.", show_default="the mission's end"),
]
DryRun = Annotated[
    bool,
    typer.Option("--dry-run", help="Listen to the links without sending, and run the checks that this allows."),
]
WriteParameters = Annotated[
    bool,
    typer.Option(
        "--write-parameters",
        help="Write parameters of the autopilot that are wrong. If there are any, do not fly; then reboot it.",
    ),
]
WriteEeprom = Annotated[bool, typer.Option("--write-eeprom", help="Correct wrong settings of the servos.")]
Unasked = Annotated[bool, typer.Option("--yes", help="Do not ask before arming.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print checklist and result as JSON; messages to stderr.")]
Pixhawk = Annotated[
    str | None,
    typer.Option(
        metavar="LINK",
        help="pixhawk.connection: udp:14540, serial:/dev/ttyACM0:921600.",
        callback=_named,
        show_default="the vehicle file's",
        rich_help_panel=_KEYS,
    ),
]
Servos = Annotated[
    str | None,
    typer.Option(
        metavar="DEVICE",
        help="servos.port: serial device of the arm's servos.",
        callback=_named,
        show_default="the vehicle file's",
        rich_help_panel=_KEYS,
    ),
]
Mocap = Annotated[
    str | None,
    typer.Option(
        metavar="LINK",
        help="mocap.connection: udp:51001 for Vicon Tracker's stream; vicon:HOST, optitrack:HOST, qualisys:HOST, "
        "vrpn:HOST; none for the autopilot's own estimate.",
        rich_help_panel=_KEYS,
    ),
]
LinkKeys = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=VALUE",
        help="Any key of the links, such as pixhawk.vehicle_system=2 or servos.baud_rate=57600; may be repeated.",
        rich_help_panel=_KEYS,
    ),
]
Setpoints = Annotated[
    SetpointKind | None,
    typer.Option(help="pixhawk.setpoints: kind of setpoints for the autopilot.", rich_help_panel=_KEYS),
]
LocalFrame = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,Z,YAW",
        help="pixhawk.local_frame: origin [m] and heading of north [rad] of the autopilot's local frame.",
        rich_help_panel=_KEYS,
    ),
]
SigningKey = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="pixhawk.signing_key: MAVLink signing key, 32 bytes or 64 hexadecimal digits.",
        rich_help_panel=_KEYS,
    ),
]
ServoIds = Annotated[
    str | None,
    typer.Option(metavar="1,2,3", help=f"servos.ids: servos {_SERVOS}.", rich_help_panel=_KEYS),
]
ServoDirections = Annotated[
    str | None,
    typer.Option(metavar="1,-1", help="servos.directions: their directions.", rich_help_panel=_KEYS),
]
ServoZeros = Annotated[
    str | None,
    typer.Option(
        metavar="2048", help="servos.zero_positions: their ticks at the joints' zeros.", rich_help_panel=_KEYS
    ),
]
ObjectName = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="mocap.object_name: the vehicle's name in the stream.", rich_help_panel=_KEYS),
]
MocapRate = Annotated[
    float | None,
    typer.Option(metavar="HZ", help="mocap.rate: frames per second of the cameras.", rich_help_panel=_KEYS),
]
