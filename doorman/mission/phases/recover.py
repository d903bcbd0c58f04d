"""A push has lost the leaf: the plan approaches it again."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then

Array = NDArray[np.float64]

_PROGRESS = math.radians(1.0)
_WHOLE_SEARCH = 3.0
"""A tip that follows a leaf which moves on by itself, or looks for it along its swing, may go on as long as it comes nearer to
the goal by that [rad], but for no more than so many time-outs."""
_FAR = 1.0
"""A tip that has looked for the leaf for longer is far from where it lost it [s]."""


class Recover(MissionPhase):
    """Ends as the tip presses again."""

    phase, at_the_leaf, guarded = Phase.RECOVER, True, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        attempt.leaf.begin(estimate.yaw, estimate)
        self._nearest, self._progress_at = estimate.door_angle, estimate.time

    def searches(self, now: float) -> bool:
        """Whether the tip is far from where it lost the leaf, or not sure to have touched it."""
        return now - self.entered > _FAR or self.attempt.unsure

    def expired(self, now: float) -> bool:
        """Whether the phase has lasted too long; progress gives more time."""
        begun = min(self._progress_at, self.entered + (_WHOLE_SEARCH - 1.0) * self.longest)
        return now - begun > self.longest

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Press gently where no plan is known yet."""
        if estimate.door_angle < self._nearest - _PROGRESS:
            self._nearest, self._progress_at = estimate.door_angle, estimate.time
        setpoint = self.attempt.leaf.push(estimate, self.attempt.touch_force)
        return setpoint, Next(Phase.OPEN, "contact regained") if estimate.touching else None

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The end of the attempt, for good where the leaf is past the goal: a push cannot bring it back."""
        if estimate.door_angle < self.attempt.model.goal_angle:
            stands = self.attempt.model.door.in_words(estimate.door_angle, 0)
            return GiveUp(f"the leaf has gone past the goal, to {stands} or farther")
        return GiveUp(f"the phase recover took longer than {self.longest:g} s", for_good=False)
