"""A straight way at a steady speed, as setpoints of the autopilot's own position control."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.hardware.pixhawk.setpoints import PositionSetpoint

SPEED = 0.4
"""Default speed of the setpoint [m/s]."""
_TURN_RATE = 0.5
"""Turn rate of the setpoint [rad/s]."""
_SHORTEST = 0.02
"""[s]."""


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
        return max(length / self.speed, abs(self._turn) / _TURN_RATE, _SHORTEST)

    @property
    def _turn(self) -> float:
        return math.remainder(self.end_yaw - self.yaw, 2.0 * math.pi)

    def setpoint(self, now: float) -> PositionSetpoint:
        """Where to be, and how fast; the end, at rest, once it is over."""
        share, way = min(max((now - self.since) / self.duration, 0.0), 1.0), self.end - self.begin
        velocity = way / self.duration if share < 1.0 else np.zeros(3)
        return PositionSetpoint(self.begin + share * way, self.yaw + share * self._turn, velocity)
