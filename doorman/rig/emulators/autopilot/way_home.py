"""A failsafe's way home, "return" or "RTL": climb if asked to, straight back at that height, land where it was armed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.estimator import Estimate
from doorman.rig.emulators.autopilot.plant import Array, yaw_of

_SPEED, _ACCELERATION = 1.5, 1.5
"""Of the setpoint on the way [m/s], [m/s²]: the real ones limit its jerk, too."""
_CLIMBED, _ARRIVED = 0.1, 0.15
"""Distances that count so [m]."""


@dataclass(frozen=True)
class Home:
    """Where the vehicle was armed, as it was believed then."""

    position: Array
    """Shape (3,), world frame [m]."""
    yaw: float
    """[rad]."""

    @classmethod
    def of(cls, estimate: Estimate) -> Home:
        """The present place."""
        return cls(estimate.position.copy(), yaw_of(estimate.quaternion))

    def distance(self, position: Array) -> float:
        """Horizontal [m]."""
        return float(np.linalg.norm((position - self.position)[:2]))

    def bearing(self, position: Array) -> float:
        """Direction from there [rad]."""
        return math.atan2(self.position[1] - position[1], self.position[0] - position[0])


class Return:
    """One flight home.

    Args:
        home: Where to.
        begin: What is believed as it begins.
        now: [s].
        height: Of the way, world frame [m].
        wait: Over home before it lands [s].
        yaw: Heading on the way; None keeps the present one [rad].
    """

    def __init__(
        self, home: Home, begin: Estimate, now: float, height: float, wait: float, yaw: float | None = None
    ) -> None:
        self._home, self._height, self._wait = home, height, wait
        self._place = begin.position.copy()
        self._yaw = yaw_of(begin.quaternion)
        self._way_yaw = self._yaw if yaw is None else yaw
        self._speed, self._last = 0.0, now
        self._climbed, self._there_since = False, math.inf

    def demand(self, estimate: Estimate, now: float) -> Demand:
        """What to do now [s]; it lands in the end."""
        dt, self._last = max(now - self._last, 0.0), now
        self._place[2] = self._height
        if not self._climbed:
            self._climbed = self._height - float(estimate.position[2]) < _CLIMBED
            return Demand(Task.POSITION, position=self._place.copy(), yaw=self._yaw)
        if self._home.distance(estimate.position) < _ARRIVED:
            self._there_since = min(self._there_since, now)
        if now - self._there_since >= self._wait:
            return Demand(Task.LAND)
        self._advance(dt)
        return Demand(Task.POSITION, position=self._place.copy(), yaw=self._way_yaw)

    def _advance(self, dt: float) -> None:
        """Move the setpoint on, so that it can stop at home."""
        way = (self._home.position - self._place)[:2]
        left = float(np.linalg.norm(way))
        self._speed = min(self._speed + _ACCELERATION * dt, _SPEED, math.sqrt(2.0 * _ACCELERATION * left))
        if left > 0.0:
            self._place[:2] += way * min(1.0, self._speed * dt / left)
