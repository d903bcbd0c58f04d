"""Along the leaf's normal at a gentle speed until the tip is stopped; then press, and try a gripper.

A mission that begins in contact begins with that trial of its gripper.
"""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Tie
from doorman.control.position_controller import Setpoint
from doorman.control.tug import TUG
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then
from doorman.planning.pace import OPEN, PRESSING, TUGGING

_TURNING_ROUND = 0.3
"""Part of the tug that the estimated force takes to follow from push to pull [s]."""
_MISSING = math.radians(5.0)
"""A tip that gets so far beyond the leaf's place before it touches anything looks for it along its swing [rad]."""


class Touch(MissionPhase):
    """Begins `TOUCH_DISTANCE` before the leaf, or on it; the opening follows once the tip has pressed for long enough."""

    phase, at_the_leaf, guarded = Phase.TOUCH, True, True
    tie = Tie.PUSHING  # a tip that is not held yet presses

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        in_contact = before is None
        self._touched_at = estimate.time - PRESSING if in_contact else None
        self._tug = TUG * attempt.model.vehicle.weight
        self._trial = TUGGING * attempt.model.contact.tied
        attempt.leaf.begin(attempt.model.start_yaw)

    @property
    def follows(self) -> bool:
        """Not if a gripper closes there, nor at a lever: that is narrow, and the tip keeps to the way to its place."""
        return super().follows and not self.attempt.model.door.in_plane

    @property
    def closes_gripper(self) -> bool:
        """Whether the tip has met the leaf."""
        return self._touched_at is not None

    def holds(self, now: float) -> bool:
        """Whether the tug has turned the force round."""
        return self._touched_at is not None and now - self._touched_at >= PRESSING + _TURNING_ROUND

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Move, press, tug; the opening follows."""
        self._feel(estimate)
        attempt, leaf = self.attempt, self.attempt.leaf
        then: Then = None
        if self._touched_at is not None:
            spent, met = estimate.time - self._touched_at, estimate.touching or self.tied
            if PRESSING <= spent < PRESSING + self._trial:
                return leaf.push(estimate, -self._tug), None
            if spent >= PRESSING and met:
                attempt.unsure = self._beyond(estimate) > _MISSING
                then = Next(Phase.OPEN)
            elif spent >= PRESSING:  # the leaf stands a little farther away than was believed
                self._touched_at = None
            if met:
                return leaf.push(estimate, attempt.touch_force), then
        if attempt.model.travel.left(estimate.door_angle) <= -OPEN:
            stands = attempt.model.door.in_words(estimate.door_angle, 0)
            return leaf.push(estimate, 0.0), GiveUp(f"the leaf has opened by itself: no leaf before {stands}")
        if self._beyond(estimate) > _MISSING:
            return leaf.search(estimate), None
        return leaf.move(estimate, attempt.settings.touch_speed), None

    def _feel(self, estimate: Estimate) -> None:
        """Notice that the tip has met the leaf, where it should be or before its place."""
        leaf, estimator = self.attempt.leaf, self.attempt.estimator
        if self._touched_at is None and estimate.touching:
            self._touched_at = estimate.time
        if self._touched_at is None and leaf.blocked(estimate):
            self._touched_at = estimate.time
            estimator.meet_leaf(estimate.tip_angle, leaf.free_wind)
        if self._touched_at == estimate.time:
            self.attempt.unsure = self._beyond(estimate) > _MISSING

    def _beyond(self, estimate: Estimate) -> float:
        """How far the leaf is beyond its place at the start [rad]."""
        return self.attempt.model.start_angle - estimate.door_angle
