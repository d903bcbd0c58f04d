"""Smooth reference motions in free flight."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.control.position_controller import Setpoint

TOUCH_DISTANCE, DOUBTED = 0.06, 3.0
"""Between the tip and what it is to touch, where it begins to feel its way: as far as a gust carries it [m], beyond so many
standard deviations of that place."""
RETREAT_SPEED = 0.25
"""Away from the door, and through the doorway [m/s]."""
_ACCELERATION = 0.25
"""Largest acceleration of a reference motion [m/s²]."""
_YAW_RATE = 0.4
"""[rad/s]."""
_ARM_GAIN = 2.0
_ARM_RATE = 0.5
"""Gain and largest rate of the arm in free flight [1/s], [rad/s]."""


class Glide:
    """Reference that moves to targets with bounded speed and acceleration, from rest; O_B in the world frame [m], ψ [rad]."""

    def __init__(self, position: Array, yaw: float) -> None:
        self.position = position.copy()
        self.velocity = np.zeros(3)
        self.yaw = yaw

    def to(self, target: Array, yaw: float, speed: float, arm_rates: Array, time_step: float) -> Setpoint:
        """Advance by one period towards a target."""
        away = target - self.position
        distance = math.sqrt(away.dot(away))
        wanted = np.zeros(3)
        if distance > 1e-9:
            wanted = min(speed, math.sqrt(_ACCELERATION * distance), 2.0 * distance) / distance * away
        change = wanted - self.velocity
        size = math.sqrt(change.dot(change))
        if size > _ACCELERATION * time_step:
            change *= _ACCELERATION * time_step / size
        self.velocity = self.velocity + change
        self.position = self.position + time_step * self.velocity
        self.yaw += min(max(yaw - self.yaw, -_YAW_RATE * time_step), _YAW_RATE * time_step)
        acceleration = change / time_step if time_step > 0.0 else np.zeros(3)
        none = np.zeros(3)
        return Setpoint(self.position.copy(), self.velocity.copy(), acceleration, self.yaw, none, none, arm_rates)

    def near(self, target: Array, tolerance: float) -> bool:
        """Whether the reference is nearer to a target than a tolerance."""
        return bool(np.linalg.norm(target - self.position) < tolerance)


def arm_rates_to(target: Array, arm_angles: Array) -> Array:
    """Joint rates towards a posture on the straight line, which a saturated joint would leave."""
    rates = _ARM_GAIN * (target - arm_angles)
    return np.asarray(rates * min(1.0, _ARM_RATE / max(float(np.abs(rates).max(initial=0.0)), 1e-9)))
