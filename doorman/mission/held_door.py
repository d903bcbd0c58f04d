"""A door that would not stay by itself: how long it is held, and what comes after."""

from __future__ import annotations

import math
from enum import Enum

from doorman.control.estimator import Estimate
from doorman.mission.progress import STILL_OPEN
from doorman.mission.since import since
from doorman.model import Model

MOVING = 0.03
"""A vehicle that grips a door which is faster does not let go of it to get away from leaf or jamb [rad/s]."""
_STANDS, _AVERAGED, _STOOD = 0.006, 0.5, 1.0
"""A held door is not left yet that has been faster within the last second, on average over half of one [rad/s], [s], [s]."""
_PATIENCE = 5.0
"""Hold times for which a held door that is not open enough is pushed again before the mission ends,"""
OPEN_ENOUGH = math.radians(2.0)
"""and is given up if it is farther off by then; nor is a door open that is farther off when the mission ends [rad]."""


class After(Enum):
    """What comes after the hold."""

    MORE = "it goes on"
    OPEN = "the mission ends, with the tip on the leaf"
    LOST = "the attempt is given up"
    LEAVE = "the mission is given up: the door is left"


class HeldDoor:
    """Watches one hold.

    Args:
        model: Model of the scenario.
        begin: When it begins [s].
        comes_back: Whether the vehicle must leave in the end: then the door is held until somebody has taken it.
    """

    def __init__(self, model: Model, begin: float, comes_back: bool) -> None:
        self._settings, self._goal = model.scenario.mission, float(model.goal_state[3])
        self._begin, self._comes_back = begin, comes_back
        self._waits = False
        self._open_at = begin
        self._rate = 0.0
        self._stands_since: float | None = None

    def judge(self, estimate: Estimate, time_step: float) -> tuple[After, str]:
        """What comes now, and why; once per tick.

        Args:
            estimate: What is known now.
            time_step: Since the last tick [s].
        """
        self._rate += min(time_step / _AVERAGED, 1.0) * (estimate.door_rate - self._rate)
        held, off = estimate.time - self._begin, abs(estimate.door_angle - self._goal)
        is_open = off < OPEN_ENOUGH
        still = off < STILL_OPEN and abs(self._rate) < _STANDS
        self._stands_since = since(self._stands_since, still, estimate.time)
        self._open_at = estimate.time if is_open else self._open_at
        if self._waits:
            if estimate.time - self._open_at > self._settings.hold_open:
                return After.LEAVE, f"the door was moved while it was held, to {math.degrees(estimate.door_angle):.0f}°"
            if is_open and held >= self._settings.time_out.hold:
                return After.LEAVE, f"the door would not stay by itself, and was left after {held:.0f} s"
            return After.MORE, ""
        stands = self._stands_since is not None and estimate.time - self._stands_since >= _STOOD
        if held < self._settings.hold_open * (1.0 if stands else _PATIENCE):
            return After.MORE, ""
        if not is_open:
            return (
                After.LOST,
                f"the door could not be held at the goal, and is at {math.degrees(estimate.door_angle):.0f}°",
            )
        self._waits = self._comes_back
        return (After.MORE if self._waits else After.OPEN), ""
