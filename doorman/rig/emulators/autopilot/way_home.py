"""A failsafe's way home, "return" or "RTL": it climbs if asked to, flies straight back, and lands where the vehicle was armed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.estimator import Estimate

_SPEED, _ACCELERATION = 1.5, 1.5
"""Speed and acceleration of the setpoint on the way [m/s], [m/s²]; real autopilots also limit its jerk."""
_CLIMBED, _ARRIVED = 0.1, 0.15
"""The vehicle has climbed, or has arrived, within these distances [m]."""


@dataclass
class WayHome:
    home: Array  # where to, shape (3,), world frame [m]
    begin: Estimate  # what is believed as it begins
    now: float  # [s]
    height: float  # of the way, world frame [m]

    def __post_init__(self) -> None:
        self._place = np.array([*self.begin.position[:2], self.height])
        self._speed, self._climbed, self._arrived = 0.0, False, False

    def demand(self, estimate: Estimate, now: float) -> Demand:
        dt, self.now = max(now - self.now, 0.0), now
        if self._climbed:
            self._arrived |= float(np.linalg.norm((self.home - estimate.position)[:2])) < _ARRIVED
            if self._arrived:
                return Demand(Task.LAND)
            self._advance(dt)
        else:
            self._climbed = self.height - float(estimate.position[2]) < _CLIMBED
        return Demand(Task.POSITION, position=self._place.copy(), yaw=self.begin.yaw)

    def _advance(self, dt: float) -> None:
        way = (self.home - self._place)[:2]
        left = float(np.linalg.norm(way))
        self._speed = min(self._speed + _ACCELERATION * dt, _SPEED, math.sqrt(2.0 * _ACCELERATION * left))
        if left > 0.0:
            self._place[:2] += way * min(1.0, self._speed * dt / left)
