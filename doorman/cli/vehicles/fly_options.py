"""Options of `doorman fly`: how its command line names them, and their help."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from doorman.cli.options import flag, valued

_FILE = "the vehicle file's"
_key = partial(valued, rich_help_panel="Instead of keys of the vehicle file")
"""Option that a vehicle file makes needless."""


def _named(context: typer.Context, parameter: typer.CallbackParam, value: str | None) -> str | None:
    """A link that the command line names, or leaves to a vehicle file; a dry run says that it is missing."""
    asked_for = context.params.get("vehicle") is None and not context.params.get("dry_run")
    if value is None and asked_for and not context.resilient_parsing:
        raise typer.BadParameter("A link is missing: give this option or --vehicle.", param_hint=parameter.opts[0])
    return value


_link = partial(_key, callback=_named)
"""Option of a link that must be named, here or in a vehicle file."""

Recording = Annotated[Path | None, valued("FILE", "Recording, as MCAP.", "a new one under runs")]
Duration = Annotated[float | None, valued("SECONDS", "End the mission after this time.", "the mission's end")]
DryRun = Annotated[
    bool,
    flag(
        "--dry-run",
        "Listen to the links without sending, and run the checks that this allows; without links, say what is needed.",
    ),
]
WriteParameters = Annotated[
    bool,
    flag(
        "--write-parameters",
        "Write parameters of the autopilot that are wrong. If there are any, do not fly; then reboot it.",
    ),
]
WriteEeprom = Annotated[bool, flag("--write-eeprom", "Correct wrong settings of the servos.")]
Unasked = Annotated[bool, flag("--yes", "Do not ask before arming.")]
Pixhawk = Annotated[str | None, _link("LINK", "pixhawk.connection: udp:14540, serial:/dev/ttyACM0:921600.", _FILE)]
Servos = Annotated[str | None, _link("DEVICE", "servos.port: serial device of the arm's servos.", _FILE)]
Mocap = Annotated[
    str | None,
    _key(
        "LINK",
        "mocap.connection: udp:51001 for Vicon Tracker's stream; vicon:HOST, optitrack:HOST, qualisys:HOST, "
        "vrpn:HOST; none for the autopilot's own estimate.",
    ),
]
LinkKeys = Annotated[
    list[str] | None,
    _key(
        "KEY=VALUE",
        "Any key of the links, such as pixhawk.vehicle_system=2 or servos.baud_rate=57600; may be repeated.",
    ),
]
Setpoints = Annotated[
    Literal["attitude", "position"] | None, _key(None, "pixhawk.setpoints: kind of setpoints for the autopilot.")
]
LocalFrame = Annotated[
    str | None,
    _key("X,Y,Z,YAW", "pixhawk.local_frame: origin [m] and heading of north [rad] of the autopilot's local frame."),
]
SigningKey = Annotated[
    Path | None, _key("FILE", "pixhawk.signing_key: MAVLink signing key, 32 bytes or 64 hexadecimal digits.")
]
ServoIds = Annotated[str | None, _key("1,2,3", "servos.ids: servos from base to tip, then the gripper's.")]
ServoDirections = Annotated[str | None, _key("1,-1", "servos.directions: their directions.")]
ServoZeros = Annotated[str | None, _key("2048", "servos.zero_positions: their ticks at the joints' zeros.")]
ObjectName = Annotated[str | None, _key("NAME", "mocap.object_name: the vehicle's name in the stream.")]
MocapRate = Annotated[float | None, _key("HZ", "mocap.rate: frames per second of the cameras.")]
