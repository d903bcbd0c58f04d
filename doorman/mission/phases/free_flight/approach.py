"""From the hover before the door to where the touch begins."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.motion import DOUBTED, TOUCH_DISTANCE
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.free_flight.hover import STEADY, fly_before_the_leaf
from doorman.mission.phases.phase import MissionPhase, Next, Phase, Then
from doorman.mission.since import since


class Approach(MissionPhase):
    """Flies to `TOUCH_DISTANCE` before the leaf, and farther where its place is doubted: what is met before is met at speed."""

    phase = Phase.APPROACH

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        assert before is not None
        self.glide = before.glide
        self._held_up_since: float | None = None

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Fly on; the touch follows there, or where something before the leaf's place holds the vehicle up."""
        normal, from_hinge = estimate.normal, estimate.contact_point - self.attempt.model.door.hinge_position
        doubt = self.attempt.place.deviation(from_hinge, normal, estimate.time)
        away = -(TOUCH_DISTANCE + DOUBTED * doubt) * normal
        setpoint, target = fly_before_the_leaf(self.attempt, self.glide, estimate, away, time_step)
        assert self.glide is not None
        waits = self.glide.near(target, 0.01)
        if waits and np.linalg.norm(estimate.position - target) < 0.05:
            return setpoint, Next(Phase.TOUCH)
        self._held_up_since = since(self._held_up_since, waits, estimate.time)
        met = self._held_up_since is not None and estimate.time - self._held_up_since >= STEADY
        return setpoint, Next(Phase.TOUCH, "something stands before the leaf") if met else None
