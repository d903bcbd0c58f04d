"""What the supervisor sees of a good flight, and of every fault."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.hardware.dynamixel import BusState, ServoFault
from doorman.hardware.mocap import PoseQuality
from doorman.hardware.pixhawk import Authority, EventKind
from doorman.hardware.safety import Fault, Observation

GOOD = Observation(
    now=100.0, position=np.array([-1.0, 0.7, 1.3]), speed=0.1, tilt=0.05, thrust_share=0.6, force=1.0,
    pose=PoseQuality.MEASURED, divergence=0.005, battery=0.8,
)  # fmt: skip
BROKEN: dict[Fault, dict[str, Any]] = {
    Fault.PILOT: {"authority": Authority.LOST},
    Fault.LINK: {"conditions": frozenset({EventKind.LINK_LOST})},
    Fault.HEARTBEAT: {"conditions": frozenset({EventKind.HEARTBEAT_LOST})},
    Fault.STATE: {"conditions": frozenset({EventKind.STATE_STALE}), "pose": None},
    Fault.TELEMETRY: {"conditions": frozenset({EventKind.STATE_STALE, EventKind.HEARTBEAT_LOST})},
    Fault.POSE_JUMPED: {"pose_jumped": True},
    Fault.POSE_LATE: {"pose_age": 1.3},
    Fault.INCONSISTENT: {"misfit": 5.0},
    Fault.SERVOS_JUMPED: {"servo_fault": ServoFault.JUMPED},
    Fault.POSE: {"pose": PoseQuality.LOST},
    Fault.DIVERGENCE: {"divergence": 0.3},
    Fault.DISOBEDIENCE: {"disobedience": 0.3},
    Fault.TILT: {"tilt": 0.9},
    Fault.BATTERY_CRITICAL: {"battery": 0.05},
    Fault.CONTROLLER: {"command_age": 0.4},
    Fault.FENCE: {"position": np.array([-1.0, 0.7, 3.5])},
    Fault.SPEED: {"speed": 2.0},
    Fault.FORCE: {"force": 25.0},
    Fault.THRUST: {"thrust_share": 1.0},
    Fault.SERVOS_DISCONNECTED: {"servo_state": BusState.DISCONNECTED},
    Fault.GRIPPER: {"grip_failed": True},
    Fault.TELEMETRY_GRIPPING: {"grips_unheard": True},
    Fault.SERVOS_FAILED: {"servo_fault": ServoFault.OVERLOAD},
    Fault.SERVOS_STOPPED: {"servo_state": BusState.HOLDING, "servo_fault": ServoFault.STALE},
    Fault.DEADLINES: {"missed_ticks": 0.8},
    Fault.BATTERY_LOW: {"battery": 0.15},
    Fault.BATTERY_SILENT: {"conditions": frozenset({EventKind.BATTERY_SILENT})},
}
"""What an observation shows of every fault."""
