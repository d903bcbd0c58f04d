"""Through the doorway of a door that has been opened and let go of, to a hover behind it."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.motion import RETREAT_SPEED, Glide, arm_rates_to
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then

_AT_THE_ENTRANCE = 0.03
"""Distance from it, and from places before it, within which the vehicle goes on [m]; its posture within twice that [rad]."""
_ARRIVED = 0.1
"""Distance from the last place within which the mission is over [m]."""


class Through(MissionPhase):
    """Takes the posture of the way where it is, flies to the entrance, and goes straight on.

    A mission that is aborted before the doorway ends there; between the jambs the vehicle goes out to the nearer side.
    """

    phase, leaves, gives_way = Phase.THROUGH, True, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        assert before is not None and before.glide is not None and attempt.passage is not None
        self.glide: Glide = before.glide
        self._passage = attempt.passage
        self._way = [self.glide.position, *self._passage.around, self._passage.entrance, self._passage.exit]

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Fly on through the doorway."""
        passage, position = self._passage, estimate.position
        if self.attempt.aborted:
            self._way = [passage.entrance if passage.into(position) < 0.0 else passage.exit]
        target = self._way[0]
        rates, speed = arm_rates_to(passage.arm, estimate.arm_angles), RETREAT_SPEED
        setpoint = self.glide.to(target, passage.yaw, speed, rates, time_step)
        off = float(np.linalg.norm(position - target))
        over = self.attempt.aborted and passage.outside(position)
        if len(self._way) == 1:
            over = over or (off < _ARRIVED and self.glide.near(target, 0.02))
        elif off < _AT_THE_ENTRANCE and self._is_ready(estimate):
            self._way.pop(0)
        return setpoint, Next(Phase.DONE, self.attempt.failure) if over else None

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The end: the vehicle hovers where it is."""
        return self.ends_here()

    def _is_ready(self, estimate: Estimate) -> bool:
        """Whether heading and arm are those of the way."""
        turned = abs(math.remainder(estimate.yaw - self._passage.yaw, 2.0 * math.pi))
        moved = np.abs(estimate.arm_angles - self._passage.arm).max(initial=0.0)
        return bool(max(turned, moved) < 2.0 * _AT_THE_ENTRANCE)
