"""The way out of the doorway, back to a hover before the door."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Tie
from doorman.control.motion import RETREAT_SPEED, Glide, arm_rates_to
from doorman.control.position_controller import Setpoint
from doorman.control.way_out import in_the_doorway, way_out
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then

_FIRST = 0.5
"""Share of the way back from a lever that is left when the arm begins to move into the start's posture."""
_PRESSED = 0.3
"""A vehicle that a leaf follows, or keeps from a place on its way out, for so long [s] goes straight out."""


class Retreat(MissionPhase):
    """Back from the leaf, out of the doorway, then into the start's posture.

    In the doorway heading and arm keep step with the leaf: one that shuts meets the tip, and not the rotors.
    """

    phase, leaves = Phase.RETREAT, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        self.glide: Glide = Glide(estimate.position, estimate.yaw)
        self._targets = way_out(attempt.model, estimate.position, estimate.door_angle)
        self._blocked_at: float | None = None
        self._was_free = before is not None and before.tie is Tie.FREE

    @property
    def tie(self) -> Tie:
        """A tip that has let go of an opened door may still rest on it; one that was not at the leaf is not there now."""
        return Tie.FREE if self._was_free else Tie.LEAVING

    def speed_back(self, estimate: Estimate) -> float:
        """Speed with which the reference goes back from the leaf [m/s]."""
        return max(0.0, -float(self.glide.velocity @ estimate.normal))

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Go on; outside the doorway the mission is over, or another attempt begins."""
        setpoint, arrived = self._fly(estimate, time_step)
        if not arrived:
            return setpoint, None
        attempt = self.attempt
        if attempt.again:
            return setpoint, Next(Phase.HOVER, attempt.begin_anew())
        through = attempt.opened and attempt.passage is not None and not (attempt.failure or attempt.aborted)
        return setpoint, Next(Phase.THROUGH) if through else Next(Phase.DONE, attempt.failure)

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The end: the vehicle hovers where it is."""
        return self.ends_here()

    def _fly(self, estimate: Estimate, time_step: float) -> tuple[Setpoint, bool]:
        """What to do, and whether the vehicle has arrived before the door."""
        model = self.attempt.model
        target, outside = self._targets[0], len(self._targets) == 1
        within = in_the_doorway(model, estimate.position)
        meets = max(estimate.tip_angle, estimate.door_angle)
        near_wall = model.door.side == "pull"  # the arm, turned back, would sweep along it
        posture = model.on_the_way(meets) if within or near_wall else model.start_state
        rates = arm_rates_to(np.asarray(posture[5:]), estimate.arm_angles)
        if model.door.in_plane and np.linalg.norm(target - estimate.position) > _FIRST * np.linalg.norm(
            model.hover_offset
        ):
            rates = np.zeros_like(rates)  # an arm that was drawn in would reach the face
        setpoint = self.glide.to(target, float(posture[2]), RETREAT_SPEED, rates, time_step)
        followed = within and estimate.touching
        if followed:  # gives way backwards only: beside it are the jambs
            along = model.door.along
            setpoint = replace(setpoint, force=float(along @ estimate.tip_force) * along)
        near = self.glide.near(target, 0.02)
        if outside or not (near or followed):
            self._blocked_at = None
        elif self._blocked_at is None:
            self._blocked_at = estimate.time
        pressed = self._blocked_at is not None and estimate.time - self._blocked_at >= _PRESSED
        arrived = pressed or (near and bool(np.linalg.norm(estimate.position - target) < 0.1))
        if arrived and not outside:
            self._targets.pop(0)
        return setpoint, arrived and outside
