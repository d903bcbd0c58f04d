"""What an emulated autopilot takes setpoint messages for; None for one that is ill-defined."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.arrays import Array
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.rules.dialects import Dialect
from doorman.rig.emulators.autopilot.vehicle.control import Demand, Task
from doorman.rig.emulators.autopilot.vehicle.plant import FLIP, NOTHING, thrust_axis

FLIP_QUATERNION = np.array([1.0, 1.0, -1.0, -1.0])
"""FRD to NED of body to world, and back."""
_RATES, _UNUSED, _THRUST_BODY = 7, 0x40 | 0x80, 0x20
"""Bits of SET_ATTITUDE_TARGET: body rates are ignored; thrust or attitude are; thrust is a vector in the body."""
_UNIT_TOLERANCE = 1e-3
_THRUST_AS_THRUST = 8
"""Bit of GUID_OPTIONS; without it, thrust is a climb rate, which doorman does not use."""


def attitude_demand(dialect: Dialect, parameters: ParameterStore, message: Any) -> Demand | None:
    """SET_ATTITUDE_TARGET."""
    mask, quaternion, thrust = message.type_mask, np.array(message.q) * FLIP_QUATERNION, message.thrust
    x = y = 0.0
    if mask & _THRUST_BODY and dialect.takes_body_thrust:
        x, y, thrust = (_thrust_body(message) * FLIP).tolist()
    unit = abs(float(np.linalg.norm(quaternion)) - 1.0) <= _UNIT_TOLERANCE
    takes = int(parameters.get("GUID_OPTIONS", _THRUST_AS_THRUST)) & _THRUST_AS_THRUST
    if mask & (_RATES | _UNUSED) != _RATES or not unit or not np.isfinite([thrust, x, y]).all() or not takes:
        return None
    thrust = min(max(thrust, 0.0), 1.0)
    if parameters.get("ATC_ANGLE_BOOST", 0.0):
        thrust = min(1.0, thrust / min(max(float(thrust_axis(quaternion)[2]), 0.1), 1.0))
    return Demand(Task.ATTITUDE, quaternion=quaternion, thrust=thrust, side=(x, y))


def position_demand(message: Any) -> Demand | None:
    """SET_POSITION_TARGET_LOCAL_NED: a position, a velocity or both."""
    mask, yaw = message.type_mask, -message.yaw
    position, velocity, acceleration = (
        NOTHING if mask & ignored else np.array(values) * FLIP
        for ignored, values in (
            (0x7, (message.x, message.y, message.z)),
            (0x38, (message.vx, message.vy, message.vz)),
            (0x1C0, (message.afx, message.afy, message.afz)),
        )
    )
    finite = np.isfinite([position, velocity, acceleration]).all()
    if message.coordinate_frame != mavlink.MAV_FRAME_LOCAL_NED or (mask & 0x7 and mask & 0x38) or not finite:
        return None
    heading = None if mask & 0x400 or not math.isfinite(yaw) else yaw
    task = Task.VELOCITY if mask & 0x7 else Task.POSITION
    return Demand(task, position=position, velocity=velocity, acceleration=acceleration, yaw=heading)


def _thrust_body(message: Any) -> Array:
    """Extension of SET_ATTITUDE_TARGET that the dialect here does not have; zeros where it was not sent, or cut off as such."""
    frame = bytes(message.get_msgbuf())
    known, payload = message.unpacker.size, frame[10 : 10 + frame[1]] if frame[0] == 0xFD else b""
    return np.array(struct.unpack("<3f", payload[known : known + 12].ljust(12, b"\0")))
