"""What an emulated autopilot takes setpoint messages for; None for one that is ill-defined. World frame."""

from __future__ import annotations

import math

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.dialects import Dialect
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.plant import Array, thrust_axis

_RATES, _UNUSED, _THRUST_BODY = 7, 0x40 | 0x80, 0x20
"""Bits of SET_ATTITUDE_TARGET: body rates are ignored; thrust or attitude are; thrust is a vector in the body."""
_UNIT_TOLERANCE = 1e-3
_THRUST_AS_THRUST = 8
"""Of GUID_OPTIONS: without it thrust is a climb rate, by which nobody flies here."""


def attitude_demand(
    dialect: Dialect, parameters: ParameterStore, mask: int, quaternion: Array, thrust: float, body: Array
) -> Demand | None:
    """SET_ATTITUDE_TARGET.

    Args:
        dialect: Of the autopilot.
        parameters: Of the autopilot.
        mask: Of the message.
        quaternion: [w, x, y, z], body to world, shape (4,).
        thrust: Normalised, 0 to 1.
        body: Thrust to the front, to the left and up, normalised, shape (3,); used if the mask says so.
    """
    unit = abs(float(np.linalg.norm(quaternion)) - 1.0) <= _UNIT_TOLERANCE
    finite = np.isfinite([thrust, *body]).all()
    takes = "GUID_OPTIONS" not in parameters or int(parameters["GUID_OPTIONS"]) & _THRUST_AS_THRUST
    if mask & (_RATES | _UNUSED) != _RATES or not unit or not finite or not takes:
        return None
    x, y, thrust = body.tolist() if mask & _THRUST_BODY and dialect.takes_body_thrust else (0.0, 0.0, thrust)
    thrust = min(max(thrust, 0.0), 1.0)
    if "ATC_ANGLE_BOOST" in parameters and parameters["ATC_ANGLE_BOOST"]:
        thrust = min(1.0, thrust / min(max(float(thrust_axis(quaternion)[2]), 0.1), 1.0))
    return Demand(Task.ATTITUDE, quaternion=quaternion, thrust=thrust, side=(x, y))


def position_demand(
    mask: int, frame: int, position: Array, velocity: Array, acceleration: Array, yaw: float
) -> Demand | None:
    """SET_POSITION_TARGET_LOCAL_NED: a position, a velocity or both.

    Args:
        mask: Of the message.
        frame: Of the message; only MAV_FRAME_LOCAL_NED is taken.
        position: Shape (3,) [m].
        velocity: Shape (3,) [m/s].
        acceleration: Shape (3,) [m/s²].
        yaw: [rad].
    """
    nothing = np.zeros(3)
    has_position, has_velocity = not mask & 7, not mask & 0x38
    position, velocity = position if has_position else nothing, velocity if has_velocity else nothing
    acceleration = nothing if mask & 0x1C0 else acceleration
    finite = np.isfinite([*position, *velocity, *acceleration]).all()
    if frame != mavlink.MAV_FRAME_LOCAL_NED or not (has_position or has_velocity) or not finite:
        return None
    task = Task.POSITION if has_position else Task.VELOCITY
    heading = None if mask & 0x400 or not math.isfinite(yaw) else yaw
    return Demand(task, position=position, velocity=velocity, acceleration=acceleration, yaw=heading)
