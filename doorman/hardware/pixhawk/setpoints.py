"""Setpoints, the messages that carry them, and a straight way at a steady speed made of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from doorman.arrays import Array, sealed
from doorman.checks import vector
from doorman.clocks import LOOK
from doorman.exceptions import DimensionError
from doorman.hardware.pixhawk.sample import LARGEST
from doorman.hardware.pixhawk.wire.frames import LocalFrame, flu_to_frd
from doorman.hardware.pixhawk.wire.messages import BodyThrustMessage, Message, mavlink
from doorman.kinematics.rotations import quaternion_of

ATTITUDE_AND_THRUST = 7
"""Type mask of SET_ATTITUDE_TARGET: body rates are ignored."""
THRUST_BODY_SET = 32
"""Bit of it: the three numbers of `thrust_body` count instead of `thrust`."""
POSITION_AND_YAW = 2552
"""Type mask of SET_POSITION_TARGET_LOCAL_NED: position and yaw only."""
FULL_POSITION = 2048
"""Position, velocity, acceleration and yaw; the yaw rate is ignored."""
SPEED = 0.4
"""Default speed on a straight way [m/s]."""
_TURN_RATE = 0.5
"""Turn rate on it [rad/s]."""
AT_REST = 0.15
"""Speed below which a vehicle hovers in place [m/s]."""


@dataclass(frozen=True)
class AttitudeSetpoint:
    """Attitude and thrust, the paper's way."""

    thrust: float
    """f along the body's z axis [N]."""
    attitude: Array
    """[φ, θ, ψ], shape (3,) [rad]."""
    side_force: tuple[float, float] = (0.0, 0.0)
    """Along the body's x and y axis, of a fully actuated vehicle [N]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "attitude", _frozen(self.attitude, "setpoint.attitude"))
        for value, name in ((self.thrust, "thrust"), *((each, "side_force") for each in self.side_force)):
            _check_number(value, f"setpoint.{name}")


@dataclass(frozen=True)
class PositionSetpoint:
    """Position, velocity, acceleration and yaw; the autopilot flies them."""

    position: Array
    """Shape (3,), world frame [m]."""
    yaw: float
    """[rad]."""
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    """Shape (3,), world frame [m/s]."""
    acceleration: Array = field(default_factory=lambda: np.zeros(3))
    """Shape (3,), world frame [m/s²]."""

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "acceleration"):
            object.__setattr__(self, name, _frozen(getattr(self, name), f"setpoint.{name}"))
        _check_number(self.yaw, "setpoint.yaw")


Setpoint = AttitudeSetpoint | PositionSetpoint


@dataclass(frozen=True)
class StraightWay:
    """From where the vehicle is to another place, turning on the way."""

    since: float  # when it begins, by the clock that `setpoint` is asked with [s]
    begin: Array  # shape (3,), world frame [m]
    end: Array  # shape (3,), world frame [m]
    yaw: float  # at the beginning [rad]
    end_yaw: float  # at the end, by the shorter turn [rad]
    speed: float = SPEED  # of the setpoint [m/s]

    @property
    def duration(self) -> float:
        length = float(np.linalg.norm(self.end - self.begin))
        return max(length / self.speed, abs(self._turn) / _TURN_RATE, LOOK)

    @property
    def _turn(self) -> float:
        return math.remainder(self.end_yaw - self.yaw, 2.0 * math.pi)

    def setpoint(self, now: float) -> PositionSetpoint:
        """Where to be, and how fast; the end, at rest, once it is over."""
        share, way = min(max((now - self.since) / self.duration, 0.0), 1.0), self.end - self.begin
        velocity = way / self.duration if share < 1.0 else np.zeros(3)
        return PositionSetpoint(self.begin + share * way, self.yaw + share * self._turn, velocity)


def attitude_message(
    setpoint: AttitudeSetpoint, thrust: float, frame: LocalFrame, boot_ms: int, target: tuple[int, int],
    side: Sequence[float] | None,
) -> Message:  # fmt: skip
    """SET_ATTITUDE_TARGET with normalised thrust, and a normalised force to the side if there is one."""
    quaternion = frame.quaternion_to_ned(quaternion_of(setpoint.attitude.tolist())).tolist()
    if side is None:
        return mavlink.MAVLink_set_attitude_target_message(
            boot_ms, *target, ATTITUDE_AND_THRUST, quaternion, 0.0, 0.0, 0.0, thrust
        )
    body, mask = flu_to_frd([*side, thrust]).tolist(), ATTITUDE_AND_THRUST | THRUST_BODY_SET
    return BodyThrustMessage(body, boot_ms, *target, mask, quaternion, 0.0, 0.0, 0.0, thrust)


def position_message(
    setpoint: PositionSetpoint, frame: LocalFrame, boot_ms: int, target: tuple[int, int], *, hold: bool
) -> Message:
    """SET_POSITION_TARGET_LOCAL_NED; of a hold, position and yaw alone count."""
    mask = POSITION_AND_YAW if hold else FULL_POSITION
    position = frame.position_to_ned(setpoint.position).tolist()
    velocity, acceleration = (frame.vector_to_ned(one).tolist() for one in (setpoint.velocity, setpoint.acceleration))
    return mavlink.MAVLink_set_position_target_local_ned_message(
        boot_ms, *target, mavlink.MAV_FRAME_LOCAL_NED, mask, *position, *velocity, *acceleration,
        frame.yaw_to_ned(setpoint.yaw), 0.0,
    )  # fmt: skip


def _check_number(value: float, name: str) -> None:
    if not math.isfinite(value) or abs(value) > LARGEST:
        raise DimensionError("not a usable number", field=name, given=value, allowed=f"finite, at most {LARGEST:g}")


def _frozen(values: Array, name: str) -> Array:
    array = vector(values, 3, name)
    if np.abs(array).max() > LARGEST:
        raise DimensionError("out of all bounds", field=name, given=array.tolist(), allowed=f"at most {LARGEST:g}")
    return sealed(array)
