"""Opening of a gripped door: following plans until it stands at the goal."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.opening.door_opening import HEADING_LOST, DoorOpening
from doorman.mission.opening.held_leaf import HeldLeaf
from doorman.mission.opening.resistance import Resistance
from doorman.mission.schedule import PlanSchedule
from doorman.mission.since import since
from doorman.model import Model

Array = NDArray[np.float64]

_STUCK = 10.0
"""Time without progress after which an opening is given up [s]."""
_TOO_FAR_AHEAD = math.radians(22.0)
_GIVES_WAY, _LEANS = 0.05, 0.3
"""A gripping vehicle that is turned farther ahead of a door that is slower for so long leans on it, and is turned on [rad],
[rad/s], [s]."""


class Opening(DoorOpening):
    """Setpoints from the touch until the door is open.

    Args:
        model: Model of the scenario.
        held_leaf: Motion with the leaf in the gripper.
        schedule: Plans.
    """

    def __init__(self, model: Model, held_leaf: HeldLeaf, schedule: PlanSchedule) -> None:
        super().__init__(model, schedule, pushes=False)
        self._held_leaf = held_leaf
        self.resistance = Resistance(model, self._progress)
        """What the hinge resists with."""
        self._leans_since: float | None = None

    def resume(self, now: float, push: float) -> None:
        """Begin."""
        self._held_leaf.begin(now)
        self._progress.resume(now)
        self._last, self._leans_since = now, None

    def hold_again(self, estimate: Estimate, push: float) -> None:
        """Bring a door that was held before back to the goal."""
        self.resume(estimate.time, push)

    def keeps_the_door(self, estimate: Estimate) -> bool:
        """Whether the door may stay by itself."""
        return self.resistance.keeps_the_door(estimate)

    def done(self, now: float) -> bool:
        """Whether the door has stood at the goal for long enough. Friction may then hold it where it is near enough."""
        done = super().done(now)
        self.resistance.is_open = self.resistance.is_open or done
        return done

    def step(self, estimate: Estimate, body_rates: Array) -> Setpoint:
        """Setpoint for now."""
        time_step, self._last = estimate.time - self._last, estimate.time
        self.resistance.learn(estimate, time_step)
        self._progress.update(estimate, False, time_step)
        ahead = self._held_leaf.ahead(estimate.yaw, estimate.door_angle) > _TOO_FAR_AHEAD
        leans = ahead and abs(self._progress.rate) < _GIVES_WAY
        self._leans_since = since(self._leans_since, leans, estimate.time)
        return self._held_leaf.follow(estimate, body_rates, lambda: self.resistance.torque(estimate, time_step))

    def stuck(self, estimate: Estimate) -> str:
        """Reason to give the opening up; empty if there is none. See `DoorOpening`."""
        if silence := self._silence(estimate.time):
            return silence
        angle = self._model.door.in_words(estimate.door_angle)
        ahead = self._held_leaf.ahead(estimate.yaw, estimate.door_angle)
        if self._leans_since is not None and estimate.time - self._leans_since > _LEANS:
            return f"the door does not give way: the vehicle is {math.degrees(ahead):.0f}° ahead of it at {angle}"
        if abs(ahead) > HEADING_LOST:
            turned = math.degrees(abs(ahead))
            return f"the heading is lost: {turned:.0f}° off at {angle}"
        if self._progress.stuck_for(estimate.time) < _STUCK:
            return ""
        return self._does_not_move(estimate, max(0.0, self._model.coupling.lever_length * estimate.normal_force))
