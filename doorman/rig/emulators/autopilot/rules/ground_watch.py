"""Whether an emulated autopilot takes its vehicle for landed, and when a landing is over."""

from __future__ import annotations

import math

from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.vehicle.control import Task

_STANDING, _STUCK = 0.1, 1.0
"""A landing that sinks more slowly [m/s] for this time [s] has stopped, as land detectors find it."""
_LAND_DETECTION = 1.0
"""Between touching the ground in a landing and disarming, where no parameter says so [s]."""


class GroundWatch:
    """Land detector of one autopilot."""

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
