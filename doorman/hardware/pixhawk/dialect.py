"""What differs between PX4 and ArduPilot, as data; which of them it is says the heartbeat.

Flight modes have numbers on the wire and names for people (PX4 user guide; ArduCopter's mode numbers).
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

from doorman.hardware.pixhawk.wire.messages import mavlink

MULTIROTORS = frozenset({2, 3, 13, 14, 15, 29, 35})
"""MAV_TYPE of quadrotor, coaxial, hexarotor, octorotor, tricopter, dodecarotor, decarotor."""

_INTEGERS = {1: ("B", 1), 2: ("b", 1), 3: ("H", 2), 4: ("h", 2), 5: ("I", 4), 6: ("i", 4)}
"""Struct code and size of the integer MAV_PARAM_TYPEs."""


_PX4_MAIN = {
    1: "manual", 2: "altitude", 3: "position", 4: "auto", 5: "acro", 6: "offboard", 7: "stabilized", 8: "rattitude",
    9: "simple", 10: "termination", 11: "altitude cruise",
}  # fmt: skip
_PX4_AUTO = {
    1: "ready", 2: "take-off", 3: "loiter", 4: "mission", 5: "return", 6: "land", 8: "follow", 9: "precision land",
    10: "VTOL take-off", 20: "descend",
}  # fmt: skip
_ARDUPILOT = {
    0: "stabilize", 1: "acro", 2: "altitude hold", 3: "auto", 4: "guided", 5: "loiter", 6: "return", 7: "circle", 9: "land",
    11: "drift", 13: "sport", 14: "flip", 15: "autotune", 16: "position hold", 17: "brake", 18: "throw", 19: "avoid",
    20: "guided without GPS", 21: "smart return", 22: "flow hold", 23: "follow", 24: "zigzag", 25: "system identification",
    26: "autorotate", 27: "auto return", 28: "turtle",
}  # fmt: skip


@dataclass(frozen=True)
class Mode:
    number: int  # `custom_mode` of HEARTBEAT
    name: str

    def __str__(self) -> str:
        return self.name


def px4_number(main: int, sub: int = 0) -> int:
    return main << 16 | sub << 24


def px4_mode(number: int) -> Mode:
    """Mode of PX4 from a `custom_mode`; the sub mode counts in auto only."""
    main, sub = number >> 16 & 0xFF, number >> 24 & 0xFF
    name = _PX4_MAIN.get(main, f"mode {main}")
    if main == 4:
        return Mode(px4_number(main, sub), f"{name}: {_PX4_AUTO.get(sub, f'mode {sub}')}")
    return Mode(px4_number(main), name)


def ardupilot_mode(number: int) -> Mode:
    return Mode(number, _ARDUPILOT.get(number, f"mode {number}"))


@dataclass(frozen=True)
class Dialect:
    name: str
    autopilot: int  # MAV_AUTOPILOT of its heartbeat
    companion_mode: Mode  # in which it obeys this computer
    land_mode: Mode  # which is asked for to land
    land_modes: frozenset[Mode]
    """Modes in which it lands as requested: PX4 descends where it does not know its height or its place."""
    mode: Callable[[int], Mode]  # mode of a `custom_mode`
    parameters_bytewise: bool
    """Whether integer parameters travel as the bytes of the float field, rather than as its value."""
    needs_stream: bool  # whether setpoints must stream before it enters the companion mode, and go on to stay in it
    takes_off_by_command: bool  # whether NAV_TAKEOFF must lift it off, rather than a setpoint above it
    angle_boost: bool
    """Whether it divides the commanded thrust by the cosine of the commanded tilt, unless `ATC_ANGLE_BOOST` is 0."""
    keeps_tilt: bool  # whether its position control begins with the tilt that it finds, as if wind asked for it
    hover_parameter: str  # parameter that holds the normalised thrust in hover
    says_what_is_valid: bool
    """Whether positions come that it does not believe itself, and ESTIMATOR_STATUS says so; else only valid ones come."""
    asks_time: bool
    """Whether it maps stamps of poses by TIMESYNC requests of its own, which not every link streams unless asked to."""
    takes_thrust: frozenset[int]  # MAV_TYPEs whose thrust it takes from attitude setpoints
    no_place: float
    """Fourth to sixth parameter of COMMAND_LONG that mean none: ArduPilot before 4.5 makes integers of two of them, which NaN
    is not, and in simulation aborts."""
    mode_hint: str  # what may keep it from the companion mode although it accepted the request

    feedback_lag: float = 0.0
    """Lag with which its attitude loop answers a moment, where it follows setpoints sooner; 0 where it does not [s]."""

    def mode_parameters(self, mode: Mode) -> tuple[float, float, float]:
        if self is PX4:
            return 1.0, float(mode.number >> 16 & 0xFF), float(mode.number >> 24 & 0xFF)
        return 1.0, float(mode.number), 0.0

    def decode_parameter(self, value: float, kind: int) -> float:
        code, size = _INTEGERS.get(kind, ("", 0))
        if not self.parameters_bytewise or not code:
            return value
        return float(struct.unpack(f"<{code}", struct.pack("<f", value)[:size])[0])

    def encode_parameter(self, value: float, kind: int) -> float:
        code, size = _INTEGERS.get(kind, ("", 0))
        if not self.parameters_bytewise or not code:
            return value
        return float(struct.unpack("<f", struct.pack(f"<{code}", round(value)).ljust(4, b"\0")[:4])[0])


PX4 = Dialect(
    name="PX4",
    autopilot=mavlink.MAV_AUTOPILOT_PX4,
    companion_mode=px4_mode(px4_number(6)),
    land_mode=px4_mode(px4_number(4, 6)),
    land_modes=frozenset({px4_mode(px4_number(4, 6)), px4_mode(px4_number(4, 20))}),
    mode=px4_mode,
    parameters_bytewise=True,
    needs_stream=True,
    takes_off_by_command=False,
    angle_boost=False,
    keeps_tilt=False,
    hover_parameter="MPC_THR_HOVER",
    says_what_is_valid=True,
    asks_time=True,
    takes_thrust=MULTIROTORS - {29, 35},
    no_place=float("nan"),
    mode_hint="; PX4 1.13 and older enter it without a radio only with bit 2 (4) of COM_RCL_EXCEPT",
)
ARDUPILOT = Dialect(
    name="ArduPilot",
    autopilot=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
    companion_mode=ardupilot_mode(4),
    land_mode=ardupilot_mode(9),
    land_modes=frozenset({ardupilot_mode(9)}),
    mode=ardupilot_mode,
    parameters_bytewise=False,
    needs_stream=False,
    takes_off_by_command=True,
    angle_boost=True,
    keeps_tilt=True,
    hover_parameter="MOT_THST_HOVER",
    says_what_is_valid=False,
    asks_time=False,
    takes_thrust=MULTIROTORS,
    no_place=0.0,
    feedback_lag=0.2,  # with the gains of ardupilot.parm: a moment of 0.3 N m turned ArduCopter by 3.6 degrees
    mode_hint="",
)


def dialect_of(autopilot: int) -> Dialect | None:
    return next((dialect for dialect in (PX4, ARDUPILOT) if dialect.autopilot == autopilot), None)
