"""Parameter files that ground stations load: what the rules of `rules` want, each with its reason."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.config import PixhawkConfig
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4
from doorman.hardware.pixhawk.parameters.rules import When, rules_for

DIALECTS = {"px4": PX4, "ardupilot": ARDUPILOT}
AutopilotName = Literal["px4", "ardupilot"]
OnLoss = Literal["land", "return"]
BAUD_RATE = 921_600
"""Default baud rate of the telemetry port [1/s]."""
TELEMS = {"px4": (0, 1, 2, 3), "ardupilot": (0, 1, 2)}
"""Telemetry ports that have the same number on every board; 0 is USB."""

_FACTORY = {"FS_OPTIONS": 16}
"""Values before any change, of parameters of which a bit is set; 0 otherwise."""
_REACTION = {"px4": {"land": ("COM_OBL_RC_ACT", 4), "return": ("COM_OBL_RC_ACT", 3)},
             "ardupilot": {"land": ("FS_GCS_ENABLE", 5), "return": ("FS_GCS_ENABLE", 1)}}  # fmt: skip
"""What a vehicle does without us."""
_REAL = frozenset(
    {"COM_OF_LOSS_T", "RTL_RETURN_ALT", "NAV_ACC_RAD", "RTL_MIN_DIST", "RTL_LAND_DELAY", "EKF2_EVP_NOISE", "EKF2_EVA_NOISE",
     "EKF2_EV_DELAY", "MPC_THR_HOVER", "BAT_LOW_THR", "MIS_TAKEOFF_ALT"}
)  # fmt: skip
"""Parameters of PX4 that are no integers."""
_SLOWEST, _FASTEST = 57_600, 3_000_000
"""Rates of a port: setpoints and poses need 5 kB a second [1/s]."""
_HOVER_LIMITS = {"px4": (0.1, 0.8), "ardupilot": (0.125, 0.6875)}
"""Hover thrust that the autopilots take."""
_PX4_INTEGER, _PX4_REAL = 6, 9
"""MAV_PARAM_TYPE, as QGroundControl's files have it."""


@dataclass(frozen=True)
class Line:
    name: str
    value: float
    comment: str  # why, in words


@dataclass(frozen=True)
class Port:
    telem: int = 2  # number of the telemetry port; 0: USB, which needs no parameters
    baud_rate: int = BAUD_RATE  # [1/s]
    flow_control: bool = False  # whether RTS and CTS are wired, too


@dataclass(frozen=True)
class VehicleFigures:
    """What of scenario and vehicle goes into the parameters."""

    weight: float  # [N]
    max_thrust: float  # of all rotors [N]
    low_battery: float  # share of the charge at which the mission is given up
    hover_height: float  # of the body above its pad, before the door [m]


def parameter_lines(
    autopilot: AutopilotName, config: PixhawkConfig, figures: VehicleFigures, on_loss: OnLoss = "land",
    mocap_delay: float | None = None, port: Port | None = None,
) -> list[Line]:  # fmt: skip
    """Parameters for a set-up, in the order of the rules, and after them those of port and vehicle."""
    port = port or Port()
    if port.telem not in TELEMS[autopilot]:
        raise BackendError("no such port", field="telem", given=port.telem, allowed=f"{TELEMS[autopilot]}; 0 is USB")
    if not _SLOWEST <= port.baud_rate <= _FASTEST:
        raise BackendError("no such rate", field="baud", given=port.baud_rate, allowed=f"{_SLOWEST} to {_FASTEST} 1/s")
    name, reaction = _REACTION[autopilot][on_loss]
    values, lines = {name: float(reaction)}, []
    for rule in rules_for(DIALECTS[autopilot], config, mocap_delay):
        if rule.value is None or not rule.counts(values):
            continue
        first = rule.names[0]
        value = values.get(first, rule.value(_FACTORY.get(first, 0.0)))
        values[first] = value
        older = f"; {', '.join(rule.names[1:])} in older firmware" if rule.names[1:] else ""
        when = "" if rule.when is When.ALWAYS else f"for {rule.when.value}: "
        lines.append(Line(first, value, f"{rule.wanted}, {when}{rule.why}{older}"))
    return [*lines, *_port(autopilot, port), *_vehicle(autopilot, figures)]


def _port(autopilot: AutopilotName, port: Port) -> Iterator[Line]:
    number = port.telem
    wired = "RTS and CTS are wired" if port.flow_control else "without RTS and CTS it would wait for them"
    if number == 0:
        return
    if autopilot == "px4":
        link = f"MAV_{0 if number == 1 else 1}"
        yield Line(f"{link}_CONFIG", 100 + number, f"MAVLink on TELEM {number}, to this computer")
        yield Line(f"{link}_MODE", 2, "onboard: the messages of a companion")
        yield Line(f"{link}_RATE", 0, "up to half of what the line carries [B/s]; a radio's port has 1200")
        yield Line(f"{link}_FLOW_CTRL", int(port.flow_control), wired)
        yield Line(f"SER_TEL{number}_BAUD", port.baud_rate, f"baud rate of TELEM {number}; takes effect after a reboot")
    else:
        yield Line(f"SERIAL{number}_PROTOCOL", 2, f"MAVLink 2 on TELEM {number}, to this computer")
        yield Line(f"SERIAL{number}_BAUD", port.baud_rate // 1000, f"baud rate of TELEM {number}, in thousands")
        yield Line(f"BRD_SER{number}_RTSCTS", int(port.flow_control), wired)


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
    """The file: for PX4 as QGroundControl loads it, for ArduPilot as every ground station does."""
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
