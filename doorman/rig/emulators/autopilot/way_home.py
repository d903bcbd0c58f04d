"""A failsafe's way home, "return" or "RTL": it climbs if asked to, flies straight back, and lands where the vehicle was armed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.estimator import Estimate


@dataclass
class WayHome:
    home: Array  # where to, shape (3,), world frame [m]
    begin: Estimate  # what is believed as it begins
    now: float  # [s]
    height: float  # of the way, world frame [m]
    speed: float = 1.5  # of the setpoint [m/s]
    acceleration: float = 1.5  # of the setpoint, whose jerk real autopilots limit, too [m/s²]
    near: float = 0.15  # within which the vehicle has climbed, or has arrived [m]

    def __post_init__(self) -> None:
        self._place = np.array([*self.begin.position[:2], self.height])
        self._speed, self._climbed, self._arrived = 0.0, False, False

    def demand(self, estimate: Estimate, now: float) -> Demand:
        dt, self.now = max(now - self.now, 0.0), now
        if self._climbed:
            self._arrived |= float(np.linalg.norm((self.home - estimate.position)[:2])) < self.near
            if self._arrived:
                return Demand(Task.LAND)
            self._advance(dt)
        else:
            self._climbed = self.height - float(estimate.position[2]) < self.near
        return Demand(Task.POSITION, position=self._place.copy(), yaw=self.begin.yaw)

    def _advance(self, dt: float) -> None:
        way = (self.home - self._place)[:2]
        left = float(np.linalg.norm(way))
        self._speed = min(self._speed + self.acceleration * dt, self.speed, math.sqrt(2.0 * self.acceleration * left))
        if left > 0.0:
            self._place[:2] += way * min(1.0, self._speed * dt / left)
