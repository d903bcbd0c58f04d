"""Parameter files that ground stations load: what the rules of `parameter_rules` want, each with its reason."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from doorman.hardware.pixhawk.config import PixhawkConfig
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4
from doorman.hardware.pixhawk.parameter_rules import When, rules_for

DIALECTS = {"px4": PX4, "ardupilot": ARDUPILOT}
AutopilotName = Literal["px4", "ardupilot"]
OnLoss = Literal["land", "return"]
BAUD_RATE = 921_600
"""Of the telemetry port [1/s]."""

_FACTORY = {"FS_OPTIONS": 16.0}
"""Values before any change, of parameters of which a bit is set; 0 otherwise."""
_REACTION = {"px4": {"land": ("COM_OBL_RC_ACT", 4.0), "return": ("COM_OBL_RC_ACT", 3.0)},
             "ardupilot": {"land": ("FS_GCS_ENABLE", 5.0), "return": ("FS_GCS_ENABLE", 1.0)}}  # fmt: skip
"""What a vehicle does without us."""
_REAL = frozenset(
    {"COM_OF_LOSS_T", "RTL_RETURN_ALT", "NAV_ACC_RAD", "RTL_MIN_DIST", "RTL_LAND_DELAY", "EKF2_EVP_NOISE", "EKF2_EVA_NOISE",
     "EKF2_EV_DELAY", "MPC_THR_HOVER", "BAT_LOW_THR", "MIS_TAKEOFF_ALT"}
)  # fmt: skip
"""Parameters of PX4 that are no integers."""
_HOVER_LIMITS = {"px4": (0.1, 0.8), "ardupilot": (0.125, 0.6875)}
"""Hover thrust that the autopilots take."""
_PX4_INTEGER, _PX4_REAL = 6, 9
"""MAV_PARAM_TYPE, as QGroundControl's files have it."""


@dataclass(frozen=True)
class Line:
    """One parameter."""

    name: str
    value: float
    comment: str
    """Why, in words."""


@dataclass(frozen=True)
class VehicleFigures:
    """What of scenario and vehicle goes into the parameters."""

    weight: float
    """[N]."""
    max_thrust: float
    """Of all rotors [N]."""
    low_battery: float
    """Share of the charge at which the mission is given up."""
    hover_height: float
    """Of the body above its pad, before the door [m]."""


def parameter_lines(
    autopilot: AutopilotName, config: PixhawkConfig, figures: VehicleFigures, on_loss: OnLoss = "land",
    mocap_delay: float | None = None,
) -> list[Line]:  # fmt: skip
    """Parameters for a set-up, in the order of the rules, and after them those of port and vehicle.

    Args:
        autopilot: Who flies.
        config: The set-up.
        figures: Of the vehicle.
        on_loss: What the vehicle does without us: land where it is, or on its pad.
        mocap_delay: From exposure to sending [s]; of use to ArduPilot alone.
    """
    name, reaction = _REACTION[autopilot][on_loss]
    values, lines = {name: reaction}, []
    for rule in rules_for(DIALECTS[autopilot], config, mocap_delay):
        if rule.value is None or not rule.counts(values):
            continue
        first = rule.names[0]
        value = values.get(first, rule.value(_FACTORY.get(first, 0.0)))
        values[first] = value
        older = f"; {', '.join(rule.names[1:])} in older firmware" if rule.names[1:] else ""
        lines.append(Line(first, value, f"{rule.wanted}, {_for(rule.when)}{rule.why}{older}"))
    return [*lines, *_port(autopilot), *_vehicle(autopilot, figures)]


def _for(when: When) -> str:
    return "" if when is When.ALWAYS else f"for {when.value}: "


def _port(autopilot: AutopilotName) -> Iterator[Line]:
    if autopilot == "px4":
        yield Line("MAV_1_CONFIG", 102, "MAVLink on TELEM 2, to this computer; where it is on USB, this is not needed")
        yield Line("MAV_1_MODE", 2, "onboard: the messages of a companion")
        yield Line("SER_TEL2_BAUD", BAUD_RATE, "baud rate of TELEM 2; this line takes effect after a reboot")
    else:
        yield Line(
            "SERIAL2_PROTOCOL", 2, "MAVLink 2 on TELEM 2, to this computer; where it is on USB, this is not needed"
        )
        yield Line("SERIAL2_BAUD", BAUD_RATE // 1000, "baud rate of TELEM 2, in thousands")


def _vehicle(autopilot: AutopilotName, figures: VehicleFigures) -> Iterator[Line]:
    low, high = _HOVER_LIMITS[autopilot]
    share = figures.weight / figures.max_thrust
    px4 = autopilot == "px4"
    hover = min(max(round(math.sqrt(share) if px4 else share, 3), low), high)
    found = f"weight of {figures.weight:.1f} N by the {figures.max_thrust:.0f} N of all rotors"
    yield Line("MPC_THR_HOVER" if px4 else "MOT_THST_HOVER", hover,
               f"{'square root of the ' if px4 else ''}{found}: a beginning, measured in hover before every mission")  # fmt: skip
    battery = max(figures.low_battery - 0.05, 0.1)
    if px4:
        yield Line("BAT_LOW_THR", round(battery, 3), "share of the charge that is low: after the mission has given up")
        yield Line(
            "MIS_TAKEOFF_ALT", round(figures.hover_height, 2), "height of a take-off by hand: that of the hover [m]"
        )


def as_text(autopilot: AutopilotName, lines: list[Line], title: str) -> str:
    """The file: for PX4 as QGroundControl loads it, for ArduPilot as every ground station does.

    Args:
        autopilot: Who flies.
        lines: The parameters.
        title: Of the file, in words.
    """
    head = [
        f"# {title}",
        "# Reboot the autopilot after loading; doorman fly checks these parameters before every flight.",
    ]
    return "\n".join([*head, *(_text(autopilot, line) for line in lines)]) + "\n"


def _text(autopilot: AutopilotName, line: Line) -> str:
    if autopilot == "ardupilot":
        return f"# {line.comment}\n{line.name},{line.value:g}"
    real = line.name in _REAL
    value = f"{line.value:.9g}" if real else f"{line.value:.0f}"
    return f"# {line.comment}\n1\t1\t{line.name}\t{value}\t{_PX4_REAL if real else _PX4_INTEGER}"
