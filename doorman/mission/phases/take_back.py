"""Taking a gripped door that is given up back to where it was found: let go of farther on, a closer would fling it shut."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.motion import planned_speed_back
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then
from doorman.mission.since import since

Array = NDArray[np.float64]

THERE, _LEVELS = math.radians(1.0), 0.7
"""A door that is no farther from where it was found for so long is back [rad], [s]."""
_DRAWS_BACK = 0.35
"""Plans draw the tip back no faster [m/s]."""
_STUCK = 3.0
"""One that rests elsewhere for so long is let go where it is [s]."""


class TakeBack(MissionPhase):
    """Follows plans back to the start with the gripper closed."""

    phase, at_the_leaf = Phase.TAKE_BACK, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        self._start = attempt.model.start_angle
        self._moved_at = self.entered
        self._there_since: float | None = None

    @property
    def goal(self) -> float | None:
        """The start."""
        return self._start

    def speed_back(self, estimate: Estimate) -> float:
        """Speed with which the plan draws the tip back [m/s]."""
        return planned_speed_back(self.attempt.converter, self.attempt.schedule.current, estimate.time, _DRAWS_BACK)

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Follow the plan back."""
        attempt, now, angle = self.attempt, estimate.time, estimate.door_angle
        self._there_since = since(self._there_since, abs(angle - self._start) < THERE, now)
        there_for = 0.0 if self._there_since is None else now - self._there_since
        setpoint = attempt.leaf.push(estimate, 0.0)
        self._moved_at = self._moved_at if estimate.rests else now
        if there_for > _LEVELS:
            return setpoint, Next(Phase.RELEASE)
        if now - self._moved_at > _STUCK or attempt.schedule.is_silent(now):
            stands = attempt.model.door.in_words(angle, 0)
            return setpoint, Next(Phase.RELEASE, f"the door does not go back from {stands}")
        return setpoint, None

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The release: the door is let go where it is."""
        return Next(Phase.RELEASE, f"the phase take_back took longer than {self.longest:g} s")
