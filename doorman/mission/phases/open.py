"""Following plans until the door stands at the goal."""

from __future__ import annotations

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then
from doorman.planning.pace import OPEN

_SURE = 2.0
"""Contact with a leaf that had to be looked for, lost again within this time, may have been none [s]."""


class Open(MissionPhase):
    """Ends with the door at the goal, with the contact lost, or where going on does no good."""

    phase, at_the_leaf, guarded = Phase.OPEN, True, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        attempt.opening.resume(estimate.time)

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Follow the plan, and judge where the door is."""
        attempt = self.attempt
        attempt.opening.update(estimate)
        setpoint = attempt.leaf.push(estimate, attempt.touch_force)
        if attempt.opening.done(estimate.time):
            attempt.opened = True
            return setpoint, self._after_opening(estimate)
        if stuck := attempt.opening.stuck(estimate):
            return setpoint, GiveUp(stuck, for_good=not attempt.opening.may_go_on(estimate))
        if not (self.tied or estimate.touching or attempt.opening.near):
            return setpoint, self._lose_contact(estimate)
        return setpoint, None

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The end of the attempt, which says where the door stands; one that swings about the goal is held there."""
        attempt = self.attempt
        if abs(estimate.door_angle - attempt.model.goal_angle) < OPEN:
            attempt.opened = True
            return Next(Phase.HOLD, "the door did not come to rest")
        stands = attempt.model.door.in_words(estimate.door_angle)
        return GiveUp(f"the phase open took longer than {self.longest:g} s; the door stands at {stands}")

    def _after_opening(self, estimate: Estimate) -> Next:
        attempt = self.attempt
        if attempt.settings.then == "stay":
            if attempt.comes_back:  # a vehicle that has to land holds the door until somebody takes it
                return Next(Phase.HOLD, "the tip is to stay")
            attempt.keeps_hold = True
            return Next(Phase.DONE)
        return Next(Phase.RELEASE)

    def _lose_contact(self, estimate: Estimate) -> Next | GiveUp:
        attempt = self.attempt
        if attempt.opening.passed(estimate) and attempt.settings.then != "stay":
            attempt.opened = True
            return self._after_opening(estimate)
        attempt.unsure = attempt.unsure and estimate.time - self.entered < _SURE
        attempt.losses += 1
        if attempt.losses > attempt.settings.recoveries:
            return GiveUp(f"contact was lost {attempt.losses} times", for_good=False)
        return Next(Phase.RECOVER, f"contact lost at {attempt.model.door.in_words(estimate.door_angle)}")
