"""A door that would not stay by itself: how long it is held, and what comes after."""

from __future__ import annotations

import math
from enum import Enum

from doorman.control.estimator import Estimate
from doorman.mission.progress import STILL_OPEN
from doorman.model import Model

MOVING = 0.03
"""A held door that is faster is not left yet [rad/s]."""
_PATIENCE = 5.0
"""Hold times for which a held door that is not open enough is pushed again before the mission ends,"""
_OPEN_ENOUGH = math.radians(2.0)
"""and is given up if it is farther off by then [rad]."""


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

    def judge(self, estimate: Estimate) -> tuple[After, str]:
        """What comes now, and why; once per tick.

        Args:
            estimate: What is known now.
        """
        held, off = estimate.time - self._begin, abs(estimate.door_angle - self._goal)
        is_open = off < _OPEN_ENOUGH
        self._open_at = estimate.time if is_open else self._open_at
        if self._waits:
            if estimate.time - self._open_at > self._settings.hold_open:
                return After.LEAVE, f"the door was moved while it was held, to {math.degrees(estimate.door_angle):.0f}°"
            if is_open and held >= self._settings.time_out.hold:
                return After.LEAVE, f"the door would not stay by itself, and was left after {held:.0f} s"
            return After.MORE, ""
        stands = off < STILL_OPEN and abs(estimate.door_rate) < MOVING
        if held < self._settings.hold_open * (1.0 if stands else _PATIENCE):
            return After.MORE, ""
        if not is_open:
            return (
                After.LOST,
                f"the door could not be held at the goal, and is at {math.degrees(estimate.door_angle):.0f}°",
            )
        self._waits = self._comes_back
        return (After.MORE if self._waits else After.OPEN), ""
