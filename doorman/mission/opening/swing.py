"""Decisions while a whole-body plan opens a door and holds it: whether it is open, held, stuck, and may be let go."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.opening.at_the_leaf import AtTheLeaf
from doorman.mission.opening.door_opening import HEADING_LOST, DoorOpening
from doorman.mission.opening.progress import STILL_OPEN
from doorman.mission.schedule import PlanSchedule
from doorman.model import Model

Array = NDArray[np.float64]

_STUCK, _STUCK_IN_SWING = 10.0, 6.0
"""Time without progress after which an opening is given up, and where the door has swung: somebody holds it [s]."""
_NEARLY = math.radians(4.0)
"""A door that has swung, and stands nearer to the goal, has come back from there [rad]."""
_GUSTINESS = 1.5
"""Wind on the leaf that a door must stand, as a share of what the vehicle feels."""
_CLOSE = math.radians(1.0)
"""A door that stands this near to the goal is held [rad]."""


class Swing(DoorOpening):
    """Opening of one attempt by pushes, from the touch until the door is open.

    Args:
        model: Model of the scenario.
        leaf: Motion at the leaf, for the moment before the first plan is known.
        schedule: Plans.
    """

    def __init__(self, model: Model, leaf: AtTheLeaf, schedule: PlanSchedule) -> None:
        super().__init__(model, schedule, pushes=True)
        self._leaf = leaf
        self._goal = model.goal_angle
        self._push = 0.0

    def resume(self, now: float, push: float) -> None:
        """Begin, or go on after contact was regained."""
        self._progress.resume(now)
        self.held, self._push = False, push

    def hold_again(self, estimate: Estimate, push: float) -> None:
        """Hold a door that was held before."""
        self.resume(estimate.time, push)
        self.held = True

    def may_go_on(self, estimate: Estimate) -> bool:
        """Whether another attempt may do better: none brings a leaf back from beyond the goal. See `DoorOpening`."""
        return super().may_go_on(estimate) and not self._is_past(estimate)

    def step(self, estimate: Estimate, body_rates: Array) -> Setpoint:
        """Take in where the door is. Once per tick."""
        self._progress.update(estimate, self.held)
        off = estimate.door_angle - self._goal
        if self.held:
            self.held = off <= STILL_OPEN
        else:
            self.held = off < 0.0 or (off < _CLOSE and estimate.rests)
        return self._leaf.push(estimate, self._push)

    def keeps_the_door(self, estimate: Estimate) -> bool:
        """Whether friction is probably stronger than the closer, and the wind on leaf and vehicle besides."""
        hinge = estimate.hinge
        wind = float(np.hypot(estimate.wind[0], estimate.wind[1])) * self._model.door.wind_lever
        return hinge.spare - _GUSTINESS * wind > 0.0

    def stuck(self, estimate: Estimate) -> str:
        """Reason to give the opening up; empty if there is none. See `DoorOpening`."""
        if silence := self._silence(estimate.time):
            return silence
        heading = float(self._model.on_the_way(estimate.door_angle)[2])
        turned = abs(math.remainder(estimate.yaw - heading, 2.0 * math.pi))
        if turned > HEADING_LOST:
            angle = self._model.door.in_words(estimate.door_angle)
            return f"the heading is lost: {math.degrees(turned):.0f}° off at {angle}"
        in_swing = self._progress.swung and estimate.door_angle - self._goal > _NEARLY
        if self._progress.stuck_for(estimate.time) < (_STUCK_IN_SWING if in_swing else _STUCK):
            return ""
        if self._is_past(estimate):
            return f"the leaf has gone past the goal, to {self._model.door.in_words(estimate.door_angle)}"
        return self._does_not_move(estimate, max(0.0, self._model.coupling.lever_length * estimate.normal_force))

    def _is_past(self, estimate: Estimate) -> bool:
        """Whether the leaf stands beyond the goal, where it is not open as asked."""
        return self._goal - estimate.door_angle > STILL_OPEN
