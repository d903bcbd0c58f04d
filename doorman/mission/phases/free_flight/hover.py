"""To a hover before the door, until the vehicle is still there in the start's posture, and its attitude loop is measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.estimation.loop_test import DURATION
from doorman.control.motion import Glide, arm_rates_to
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then
from doorman.mission.since import since

_BEGINS = 3.0
"""After which what moves the vehicle counts: before, it is on its way [s]."""
_STRONG = 0.12
"""Share of the weight from which on wind is named."""
STEADY = 1.0
"""For which the vehicle must hover still before the approach, and must be held up to have met something [s]."""


class Hover(MissionPhase):
    """Flies to `hover_distance` before the contact point."""

    phase = Phase.HOVER

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        known = None if before is None else before.glide
        self.glide = known or Glide(estimate.position, estimate.yaw)
        self._still_since: float | None = None
        self._unread = "poses" in attempt.settings.measures
        self._strayed, self._felt, self._testing = 0.0, 0.0, False

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Fly on; once the vehicle is still, the approach follows, or the frame's touch where the scenario wants one."""
        model = self.attempt.model
        setpoint, target = fly_before_the_leaf(self.attempt, self.glide, estimate, model.hover_offset, time_step)
        off = float(np.linalg.norm(estimate.position - target))
        still = off < 0.06 and np.linalg.norm(estimate.velocity) < 0.08
        if estimate.time - self.entered > _BEGINS:
            self._strayed = max(self._strayed, off)
            self._felt = max(self._felt, float(np.linalg.norm(estimate.wind[:2])))
        posed = np.abs(estimate.arm_angles - model.start_arm).max(initial=0.0) < 0.03
        self._still_since = since(self._still_since, bool(still and posed), estimate.time)
        ready = self._testing or (self._still_since is not None and estimate.time - self._still_since >= STEADY)
        poses = self.attempt.poses
        if self._unread and poses.judged:
            self._unread = False
            if unfit := poses.unfit():
                return setpoint, GiveUp(unfit)
        if not ready or self._unread:
            return setpoint, None
        test = self.attempt.loop_test
        if not test.done:
            self._testing = True
            return replace(setpoint, nudge=test.step(estimate.time)), None
        if unfit := test.unfit():
            return setpoint, GiveUp(unfit)
        feels = bool(model.frame_places) and not self.attempt.place.found
        return setpoint, Next(Phase.TOUCH_FRAME if feels else Phase.APPROACH)

    @property
    def longest(self) -> float:
        """Time-out; the test of the attitude loop does not count [s]."""
        return super().longest + (DURATION if self._testing else 0.0)

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The end of the mission, which says what moved the vehicle."""
        reason = f"the vehicle did not come to hover still within {self.longest:g} s"
        if self._strayed:
            reason += f": it moved by up to {1e2 * self._strayed:.0f} cm"
        if self._felt > _STRONG * self.attempt.model.vehicle.weight:
            reason += f", and felt wind of up to {self._felt:.1f} N"
        return GiveUp(reason)


def fly_before_the_leaf(
    attempt: Attempt, glide: Glide | None, estimate: Estimate, away: Array, time_step: float
) -> tuple[Setpoint, Array]:
    """Setpoint on the way to a place before the leaf, in the start's posture."""
    assert glide is not None
    model = attempt.model
    yaw, arm = model.start_yaw, model.start_arm
    target = attempt.leaf.contact_position(estimate, yaw, arm) + away
    rates = arm_rates_to(arm, estimate.arm_angles)
    return glide.to(target, yaw, attempt.settings.approach_speed, rates, time_step), target
