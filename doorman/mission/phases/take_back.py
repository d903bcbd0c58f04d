"""Taking a held door that is given up back to where it was found: let go of farther on, a closer would fling it shut."""

from __future__ import annotations

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.opening import Opening
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then
from doorman.mission.since import since

_STUCK = 3
"""Hold times for which a door rests elsewhere before it is let go there."""


class TakeBack(MissionPhase):
    """Follows plans back to the start with the gripper closed: an opening the other way."""

    phase, at_the_leaf = Phase.TAKE_BACK, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        self._back = Opening(attempt.model, attempt.schedule, back=True)
        self._back.resume(self.entered)
        self._rests_since: float | None = None

    @property
    def goal(self) -> float | None:
        """The start."""
        return self.attempt.model.start_angle

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Follow the plan back; the release follows there, or where the door does not go back."""
        attempt, now = self.attempt, estimate.time
        self._back.update(estimate)
        setpoint = attempt.leaf.push(estimate, 0.0)
        if self._back.done(now):
            return setpoint, Next(Phase.RELEASE)
        self._rests_since = since(self._rests_since, estimate.rests and not self._back.near, now)
        stuck = self._rests_since is not None and now - self._rests_since > _STUCK * attempt.settings.hold_time
        if stuck or self._back.stuck(estimate) or attempt.schedule.is_silent(now):
            stands = attempt.model.door.in_words(estimate.door_angle, 0)
            return setpoint, Next(Phase.RELEASE, f"the door does not go back from {stands}")
        return setpoint, None

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The release: the door is let go where it is."""
        return Next(Phase.RELEASE, f"the phase take_back took longer than {self.longest:g} s")
