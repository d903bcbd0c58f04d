"""What differs between the emulated autopilots: a table each, with the real ones' parameters and how these travel."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import BackendError

_INT8, _INT16, _INT32, _REAL32 = 2, 4, 6, 9
_CODES = {_INT8: "<b", _INT16: "<h", _INT32: "<i"}
"""Struct format of an integer MAV_PARAM_TYPE."""
Defaults = dict[str, tuple[float, int]]
"""Value and MAV_PARAM_TYPE by name."""


def _typed(values: Mapping[int, Mapping[str, float]]) -> Defaults:
    return {name: (value, kind) for kind, named in values.items() for name, value in named.items()}


PX4_DEFAULTS = _typed({
    _REAL32: {"COM_OF_LOSS_T": 1.0, "COM_DISARM_LAND": 2.0, "COM_DISARM_PRFLT": 10.0, "RTL_RETURN_ALT": 60.0,
              "RTL_MIN_DIST": 10.0, "RTL_LAND_DELAY": 0.0, "NAV_ACC_RAD": 10.0, "MPC_THR_HOVER": 0.5, "THR_MDL_FAC": 0.0,
              "EKF2_EVP_NOISE": 0.1, "EKF2_EVA_NOISE": 0.1, "EKF2_EV_DELAY": 0.0},
    _INT32: {"COM_OBL_RC_ACT": 0, "COM_DL_LOSS_T": 10, "COM_LOW_BAT_ACT": 0, "NAV_DLL_ACT": 0, "NAV_RCL_ACT": 2,
             "RTL_CONE_ANG": 45, "RTL_TYPE": 0, "MPC_YAW_MODE": 0, "EKF2_EV_CTRL": 0, "EKF2_HGT_REF": 1,
             "EKF2_GPS_CTRL": 7, "EKF2_BARO_CTRL": 1, "EKF2_RNG_CTRL": 1, "EKF2_MAG_TYPE": 0},
})  # fmt: skip
"""Parameters of PX4 as delivered."""
ARDUPILOT_DEFAULTS = _typed({
    _REAL32: {"GUID_TIMEOUT": 3.0, "FS_GCS_TIMEOUT": 5.0, "BATT_LOW_VOLT": 10.5, "BATT_CRT_VOLT": 0.0,
              "MOT_THST_HOVER": 0.35, "MOT_THST_EXPO": 0.65, "MOT_BAT_VOLT_MAX": 0.0, "WPNAV_JERK": 1.0},
    _INT32: {"GUID_OPTIONS": 0, "FS_OPTIONS": 16, "RTL_ALT": 1500, "RTL_LOIT_TIME": 5000},
    _INT16: {"SYSID_MYGCS": 255, "SCHED_LOOP_RATE": 400, "VISO_DELAY_MS": 10, "RTL_CLIMB_MIN": 0,
             "RTL_ALT_FINAL": 0},
    _INT8: {"FS_GCS_ENABLE": 0, "FS_EKF_ACTION": 1, "FS_THR_ENABLE": 1, "BATT_FS_LOW_ACT": 0, "BATT_FS_CRT_ACT": 0,
            "DISARM_DELAY": 10, "ATC_ANGLE_BOOST": 1, "GPS1_TYPE": 1, "COMPASS_USE": 1, "COMPASS_USE2": 1,
            "COMPASS_USE3": 1, "EK3_SRC1_POSXY": 3, "EK3_SRC1_POSZ": 1, "EK3_SRC1_YAW": 1, "EK3_SRC1_VELXY": 3,
            "EK3_SRC1_VELZ": 3, "VISO_TYPE": 0, "VISO_QUAL_MIN": 0, "WP_YAW_BEHAVIOR": 2},
})  # fmt: skip
"""Parameters of ArduPilot as delivered."""
PX4_MOCAP: dict[str, float] = {
    "EKF2_EV_CTRL": 11, "EKF2_HGT_REF": 3, "EKF2_GPS_CTRL": 0, "EKF2_RNG_CTRL": 0,
    "EKF2_MAG_TYPE": 5, "EKF2_EVP_NOISE": 0.01, "EKF2_EVA_NOISE": 0.02,
}  # fmt: skip
"""Set-up of PX4 for flights by mocap alone."""
ARDUPILOT_MOCAP: dict[str, float] = {
    "GPS1_TYPE": 0, "COMPASS_USE": 0, "COMPASS_USE2": 0, "COMPASS_USE3": 0, "EK3_SRC1_POSXY": 6, "EK3_SRC1_POSZ": 6,
    "EK3_SRC1_YAW": 6, "EK3_SRC1_VELXY": 0, "EK3_SRC1_VELZ": 0, "VISO_TYPE": 1,
}  # fmt: skip
"""Set-up of ArduPilot for flights by mocap alone."""


class ParameterStore:
    def __init__(self, defaults: Defaults, bytewise: bool) -> None:
        self._values = dict(defaults)
        self._bytewise = bytewise
        self.writes = 0  # PARAM_SETs that were taken

    def __getitem__(self, name: str) -> float:
        return self._values[name][0]

    def __setitem__(self, name: str, value: float) -> None:
        self._values[name] = (value, self._values[name][1])

    def __delitem__(self, name: str) -> None:
        del self._values[name]

    def __contains__(self, name: str) -> bool:
        return name in self._values

    @property
    def names(self) -> list[str]:
        return list(self._values)

    def get(self, name: str, otherwise: float) -> float:
        return self[name] if name in self else otherwise

    def add(self, name: str, value: float, whole: bool = False) -> None:
        self._values[name] = (value, _INT32 if whole else _REAL32)

    def to_wire(self, name: str) -> tuple[float, int]:
        """Fields of PARAM_VALUE: the value as a float, and MAV_PARAM_TYPE."""
        value, kind = self._values[name]
        code = _CODES.get(kind) if self._bytewise else None
        raw = struct.pack("<f", value) if code is None else struct.pack(code, int(value)).ljust(4, b"\0")
        return float(struct.unpack("<f", raw)[0]), kind

    def from_wire(self, name: str, field: float, kind: int) -> bool:
        if name not in self or (self._bytewise and self._values[name][1] != kind):
            return False
        code = _CODES.get(self._values[name][1])
        if code is not None and self._bytewise:
            field = float(struct.unpack_from(code, struct.pack("<f", field))[0])
        self[name] = field if code is None else float(round(field))
        self.writes += 1
        return True


Flavour = Literal["px4", "ardupilot"]
MotorKind = Literal["linear", "quadratic"]
"""Motors that the autopilot's parameter linearises; or with the factory's parameter."""
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = 0, 1, 2, 3, 4
"""MAV_RESULT."""
_ON_REQUEST = frozenset({
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION, mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, mavlink.MAVLINK_MSG_ID_SYS_STATUS, mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN,
})  # fmt: skip


@dataclass(frozen=True)
class Dialect:
    vendor: int  # MAV_AUTOPILOT
    modes: Mapping[str, int]
    """`custom_mode` by name. In `companion` it obeys setpoints, in `position` the pilot's sticks; these two, `loiter`,
    `return` and `land` both autopilots have."""
    mode_bits: tuple[int, int]
    """What the second and third parameter of DO_SET_MODE are multiplied by to make `custom_mode`."""
    begins: str  # mode after boot
    placed: frozenset[str]  # modes that it enters only with a place on earth
    positioned: frozenset[str]  # modes that it leaves for `land` where its position gets lost
    heeds_stream: bool
    """Whether setpoints count in every mode, must come before `companion`, and go on to stay in it; else one is enough, in
    `companion`, and a bad one stops the vehicle."""
    takes_body_thrust: bool  # whether a setpoint's thrust may be a vector in the body
    lifts_off_by_command: bool  # whether NAV_TAKEOFF must lift it off, rather than a setpoint above it
    refusal: int  # MAV_RESULT of what it refuses
    bytewise: bool  # whether integer parameters travel as bytes
    asks_time: bool
    """Whether it maps stamps of poses by TIMESYNC requests of its own; else by the least lag that it saw."""
    position_timeout: float  # without poses, after which its position is lost [s]
    disarm_after: str  # parameter: longest time on the ground before a take-off [s]
    station: tuple[str, str, Mapping[int, str]]
    """Parameters of action and time-out at the loss of the ground station, and modes by action; other actions are none."""
    return_height: tuple[str, float]  # parameter of the height of a return above home, and its unit [m]
    hover_thrust: str  # parameter: normalised thrust in hover
    linearisation: str  # parameter: how far it makes thrust of the motors' signal
    parameters: Defaults  # defaults
    mocap: Mapping[str, float]  # parameters for flights by mocap alone
    rates: Mapping[int, float]  # messages of a fresh link [1/s]
    on_request: frozenset[int]  # messages that may be asked for, and whose interval may be set
    killed_for: float = 5.0  # after which a vehicle whose motors a switch has stopped is disarmed [s]
    failsafe_delay: float = 0.1  # from the end of the stream to the failsafe [s]
    off_ground: float = 0.03  # a position setpoint that much above is a take-off [m]
    standing: float = 0.1  # a landing that sinks more slowly has stopped, as land detectors find it [m/s]
    land_detection: float = 1.0
    """For which it must; and from touching the ground in a landing to disarming, where no parameter gives that [s]."""
    share_of_loop: float = 0.8  # largest rate of a message, over the rate of ArduPilot's main loop


PX4 = Dialect(
    vendor=mavlink.MAV_AUTOPILOT_PX4,
    modes={
        "companion": 6 << 16, "position": 3 << 16, "altitude": 2 << 16, "loiter": 4 << 16 | 3 << 24,
        "return": 4 << 16 | 5 << 24, "land": 4 << 16 | 6 << 24,
    },
    mode_bits=(1 << 16, 1 << 24),
    begins="loiter",
    placed=frozenset({"loiter", "return"}),
    positioned=frozenset({"position", "loiter", "return"}),
    heeds_stream=True,
    takes_body_thrust=True,
    lifts_off_by_command=False,
    refusal=TEMPORARILY_REJECTED,
    bytewise=True,
    asks_time=True,
    position_timeout=5.0,
    disarm_after="COM_DISARM_PRFLT",
    station=("NAV_DLL_ACT", "COM_DL_LOSS_T", {1: "return", 2: "return", 3: "land"}),
    return_height=("RTL_RETURN_ALT", 1.0),
    hover_thrust="MPC_THR_HOVER",
    linearisation="THR_MDL_FAC",
    parameters=PX4_DEFAULTS,
    mocap=PX4_MOCAP,
    rates={
        mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0, mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50.0,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 30.0, mavlink.MAVLINK_MSG_ID_SYS_STATUS: 5.0,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 0.5, mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 5.0,
    },
    on_request=_ON_REQUEST | {mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS, mavlink.MAVLINK_MSG_ID_TIMESYNC},
)  # fmt: skip
ARDUPILOT = Dialect(
    vendor=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
    modes={"stabilize": 0, "altitude": 2, "companion": 4, "loiter": 5, "position": 5, "return": 6, "land": 9},
    mode_bits=(1, 0),
    begins="stabilize",
    placed=frozenset({"companion", "loiter", "return"}),
    positioned=frozenset({"companion", "loiter", "return"}),
    heeds_stream=False,
    takes_body_thrust=False,
    lifts_off_by_command=True,
    refusal=FAILED,
    bytewise=False,
    asks_time=False,
    position_timeout=10.0,
    disarm_after="DISARM_DELAY",
    station=(
        "FS_GCS_ENABLE",
        "FS_GCS_TIMEOUT",
        {1: "return", 2: "return", 3: "return", 4: "land", 5: "land", 6: "return"},
    ),
    return_height=("RTL_ALT", 0.01),
    hover_thrust="MOT_THST_HOVER",
    linearisation="MOT_THST_EXPO",
    parameters=ARDUPILOT_DEFAULTS,
    mocap=ARDUPILOT_MOCAP,
    rates={mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0, mavlink.MAVLINK_MSG_ID_TIMESYNC: 0.1},
    on_request=_ON_REQUEST,
)
DIALECTS: Mapping[str, Dialect] = {"px4": PX4, "ardupilot": ARDUPILOT}


@dataclass(frozen=True)
class Build:
    flavour: Flavour = "px4"  # whose rules it follows
    vision: bool = False  # whether its position comes from VISION_POSITION_ESTIMATE, rather than from satellites
    system_id: int = 1  # its MAVLink system id
    start_up: float = 22.0  # until ArduPilot's gyros are calibrated [s]
    heartbeat_rate: float = 1.0  # [1/s]
    vehicle_type: int = 13  # MAV_TYPE; 13 is a hexarotor
    hover_thrust: float = 0.4  # share of the largest thrust at which the vehicle really hovers
    motors: MotorKind = "linear"
    """Whether its parameter linearises the motors, or is the factory's; thrust is the square of their signal with both."""
    pace: float = 1.0  # of its clock and its plant over real time, as of simulators that run faster or slower
    signing_key: bytes | None = None  # 32 bytes; with it, unsigned messages are ignored
    seed: int = 0  # of noise and faults

    def __post_init__(self) -> None:
        if self.flavour not in DIALECTS:
            raise BackendError("unknown autopilot", field="flavour", given=self.flavour, allowed="px4 or ardupilot")

    @property
    def dialect(self) -> Dialect:
        return DIALECTS[self.flavour]
