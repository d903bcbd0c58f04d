"""Whether an emulated autopilot takes its vehicle for landed, and when a landing is over."""

from __future__ import annotations

from doorman.rig.emulators.autopilot.control import Task
from doorman.rig.emulators.autopilot.parameters import ParameterStore

_STANDING, _STUCK = 0.1, 1.0
"""A landing that sinks more slowly [m/s] for this time [s] has stopped."""
_LAND_DETECTION = 1.0
"""Between touching the ground in a landing and disarming, where no parameter says so [s]."""


class GroundWatch:
    """Land detector of one autopilot.

    Args:
        parameters: Of the autopilot; COM_DISARM_LAND says when a landing is over, where there is one.
    """

    def __init__(self, parameters: ParameterStore) -> None:
        self._parameters = parameters
        self._grounded_since: float | None = None
        self._stuck_since: float | None = None

    def forget(self) -> None:
        """Begin anew, as after disarming."""
        self._grounded_since = None

    def landed(self, now: float, armed: bool, landed: bool, on_ground: bool, task: Task, climb: float) -> bool:
        """Whether it is landed: on the ground, or stuck in a landing, and not about to leave.

        Args:
            now: Of the autopilot's clock [s].
            armed: Whether it is armed.
            landed: Whether it was landed until now.
            on_ground: Whether the landing gear touches.
            task: What the vehicle does now.
            climb: Its upward velocity as estimated [m/s].
        """
        stuck = self._stuck(now, armed and task is Task.LAND and abs(climb) <= _STANDING)
        return (on_ground or stuck) and (task in (Task.IDLE, Task.LAND) or not armed or landed)

    def is_over(self, now: float, stands: bool) -> bool:
        """Whether a landing has stood for so long that the vehicle is to be disarmed.

        Args:
            now: Of the autopilot's clock [s].
            stands: Whether it is landing, armed and landed.
        """
        if not stands:
            self._grounded_since = None
            return False
        self._grounded_since = now if self._grounded_since is None else self._grounded_since
        named = "COM_DISARM_LAND" in self._parameters
        return now - self._grounded_since > (self._parameters["COM_DISARM_LAND"] if named else _LAND_DETECTION)

    def _stuck(self, now: float, halted: bool) -> bool:
        """Whether a landing has stopped on something, as land detectors find it: told to descend, it does not."""
        if not halted:
            self._stuck_since = None
            return False
        self._stuck_since = now if self._stuck_since is None else self._stuck_since
        return now - self._stuck_since > _STUCK
