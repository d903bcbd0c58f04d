"""A tip has lost the leaf: the plan approaches it again."""

from __future__ import annotations

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then

_WHOLE_SEARCH = 3
"""A tip that follows a leaf which moves on by itself, or looks for it along its swing, may go on as long as it comes nearer to
the goal, but for no more than so many time-outs."""


class Recover(MissionPhase):
    """Ends as the tip presses again."""

    phase, at_the_leaf, guarded = Phase.RECOVER, True, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        attempt.leaf.begin(estimate.yaw, estimate)
        attempt.opening.resume(estimate.time)

    def expired(self, now: float) -> bool:
        """Whether the phase has lasted too long; progress gives more time."""
        stands = self.attempt.opening.stuck_for(now) > self.longest
        return stands or now - self.entered > _WHOLE_SEARCH * self.longest

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Press gently where no plan is known yet."""
        self.attempt.opening.update(estimate)
        setpoint = self.attempt.leaf.push(estimate, self.attempt.touch_force)
        return setpoint, Next(Phase.OPEN, "contact regained") if estimate.touching else None

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The end of the attempt, for good where the leaf is past the goal: a push cannot bring it back."""
        if self.attempt.model.travel.left(estimate.door_angle) < 0.0:
            stands = self.attempt.model.door.in_words(estimate.door_angle, 0)
            return GiveUp(f"the leaf has gone past the goal, to {stands} or farther")
        return GiveUp(f"the phase recover took longer than {self.longest:g} s", for_good=False)
