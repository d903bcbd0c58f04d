"""How flights end: a land detector, and a failsafe's way home, "return" or "RTL".

That climbs if asked to, flies straight back at that height, and lands where the vehicle was armed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.dialects import ParameterStore
from doorman.rig.emulators.autopilot.estimator import Estimate

_STANDING, _STUCK = 0.1, 1.0
"""A landing that sinks more slowly [m/s] for this time [s] has stopped, as land detectors find it."""
_LAND_DETECTION = 1.0
"""Time from touching the ground in a landing to disarming, where no parameter gives it [s]."""


class GroundWatch:
    def __init__(self, parameters: ParameterStore) -> None:
        self._parameters = parameters
        self._halted_since = self._stands_since = math.inf
        """Since when a landing has stopped, and has stood on the ground [s]."""

    def landed(self, now: float, armed: bool, landed: bool, on_ground: bool, task: Task, climb: float) -> bool:
        """Whether it is landed: on the ground, or stuck in a landing, and not about to leave."""
        halted = armed and task is Task.LAND and abs(climb) <= _STANDING
        self._halted_since = min(self._halted_since, now) if halted else math.inf
        stuck = now - self._halted_since > _STUCK
        return (on_ground or stuck) and (task in (Task.IDLE, Task.LAND) or not armed or landed)

    def is_over(self, now: float, stands: bool) -> bool:
        """Whether a landing has stood for so long that the vehicle is to be disarmed."""
        self._stands_since = min(self._stands_since, now) if stands else math.inf
        return now - self._stands_since > self._parameters.get("COM_DISARM_LAND", _LAND_DETECTION)


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
