"""Opening of a gripped door: following plans until it stands at the goal."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.opening.door_opening import HEADING_LOST, DoorOpening
from doorman.mission.opening.held_leaf import HeldLeaf
from doorman.mission.schedule import PlanSchedule
from doorman.model import Model

Array = NDArray[np.float64]

_STUCK = 10.0
"""Time without progress after which an opening is given up [s]."""
_TOO_FAR_AHEAD = math.radians(22.0)
"""A gripping vehicle that is turned farther ahead of a door that rests leans on it, and is turned on [rad]."""
_UNSURE = 0.2
"""By which a room door's closer may seem to be stronger than friction for a gripped door to be tried nevertheless [N m]."""


class Opening(DoorOpening):
    """Setpoints from the touch until the door is open.

    Args:
        model: Model of the scenario.
        held_leaf: Motion with the leaf in the gripper.
        schedule: Plans.
    """

    def __init__(self, model: Model, held_leaf: HeldLeaf, schedule: PlanSchedule) -> None:
        super().__init__(model, schedule, pushes=False)
        self._held_leaf, self._unsure = held_leaf, _UNSURE * model.hinge_scale

    def resume(self, now: float, push: float) -> None:
        """Begin."""
        self._held_leaf.begin(now)
        self._progress.resume(now)

    def hold_again(self, estimate: Estimate, push: float) -> None:
        """Bring a door that was held before back to the goal."""
        self.resume(estimate.time, push)

    def keeps_the_door(self, estimate: Estimate) -> bool:
        """Whether the door may stay by itself, within a deviation: what is let go is watched then, before it is left."""
        return estimate.hinge.spare + min(estimate.hinge.spare_deviation, self._unsure) > 0.0

    def step(self, estimate: Estimate, body_rates: Array) -> Setpoint:
        """Setpoint for now."""
        self._progress.update(estimate, False)
        return self._held_leaf.follow(estimate, body_rates, lambda: estimate.door_disturbance)

    def stuck(self, estimate: Estimate) -> str:
        """Reason to give the opening up; empty if there is none. See `DoorOpening`."""
        if silence := self._silence(estimate.time):
            return silence
        angle = self._model.door.in_words(estimate.door_angle)
        ahead = self._held_leaf.ahead(estimate.yaw, estimate.door_angle)
        if ahead > _TOO_FAR_AHEAD and estimate.rests:
            return f"the door does not give way: the vehicle is {math.degrees(ahead):.0f}° ahead of it at {angle}"
        if abs(ahead) > HEADING_LOST:
            turned = math.degrees(abs(ahead))
            return f"the heading is lost: {turned:.0f}° off at {angle}"
        if self._progress.stuck_for(estimate.time) < _STUCK:
            return ""
        return self._does_not_move(estimate, max(0.0, self._model.coupling.lever_length * estimate.normal_force))
