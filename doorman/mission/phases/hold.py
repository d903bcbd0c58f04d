"""Holding a door that would not stay by itself, for a while or until somebody takes it."""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then
from doorman.planning.pace import OPEN

_PATIENCE = 5.0
"""Hold times for which a door that moves, or is not open, is held before the mission ends."""


class Hold(MissionPhase):
    """Ends with the tip on the leaf; a vehicle that comes back holds the door until somebody has taken it."""

    phase, at_the_leaf, guarded = Phase.HOLD, True, True
    longest = math.inf  # how long a door is held is judged each tick

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        self._goal = attempt.model.goal_angle
        self._waits = False
        self._open_at = self._rests_at = self.entered
        attempt.opening.resume(estimate.time)

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Go on holding, and judge whether that is over."""
        attempt = self.attempt
        attempt.opening.update(estimate)
        return attempt.leaf.push(estimate, attempt.touch_force), self._judge(estimate)

    def _judge(self, estimate: Estimate) -> Then:
        settings = self.attempt.settings
        held, off = estimate.time - self.entered, abs(estimate.door_angle - self._goal)
        is_open = off < OPEN
        self._open_at = estimate.time if is_open else self._open_at
        angle = self.attempt.model.door.in_words(estimate.door_angle, 0)
        if self._waits:
            if estimate.time - self._open_at > settings.hold_open:
                moved = f"the door was moved while it was held, to {angle}"
                return GiveUp(moved, takes_back=False)  # who has it keeps it
            if is_open and held >= settings.time_out.hold:
                return GiveUp(f"the door did not stay by itself, and the vehicle let go after {held:.0f} s")
            return None
        self._rests_at = self._rests_at if is_open and estimate.rests else estimate.time
        if estimate.time - self._rests_at < settings.hold_open and held < settings.hold_open * _PATIENCE:
            return None
        if not is_open:
            return GiveUp(f"the door could not be held at the goal, and is at {angle}", for_good=False)
        self._waits = self.attempt.comes_back
        if self._waits:
            return None
        if settings.then == "through":
            return GiveUp("the door did not stay by itself, and the vehicle does not fly through")
        self.attempt.keeps_hold = True
        return Next(Phase.DONE)
