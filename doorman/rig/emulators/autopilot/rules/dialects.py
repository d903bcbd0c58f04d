"""What differs between the emulated autopilots, as a table each; the rules that use them are those of `brain`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import BackendError
from doorman.rig.emulators.autopilot.parameters import (
    ARDUPILOT_DEFAULTS,
    ARDUPILOT_MOCAP,
    PX4_DEFAULTS,
    PX4_MOCAP,
    Defaults,
)
from doorman.rig.emulators.autopilot.vehicle.control import MotorKind

Flavour = Literal["px4", "ardupilot"]
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
