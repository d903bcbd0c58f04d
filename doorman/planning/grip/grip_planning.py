"""What plans of a vehicle that holds on to the door share, whatever their dynamics."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.composition import NOTHING
from doorman.planning.grip.push import LargestPushes, leaning, push_along_normal, too_stiff
from doorman.planning.hinge import Hinge

Array = NDArray[np.float64]


class GripPlanning(ABC):
    """What does not depend on the dynamics of a vehicle whose tip holds on to the door; see `PlanningModel`."""

    model: Model
    goal_state: Array

    @cached_property
    def _largest(self) -> LargestPushes:
        return LargestPushes(self.model)

    @abstractmethod
    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        """Reduced states and inputs, see `PlanningModel`."""

    @abstractmethod
    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        """State to plan from, see `PlanningModel`."""

    def follows_start(self, given: Mapping[str, ArrayLike] = NOTHING) -> bool:
        """False: hinge and margin say it all. See `PlanningModel`."""
        return False

    def goal(self, start: Array, hinge: Hinge, door_angle: float | None = None) -> Array:
        """The scenario's goal, or a place on the way there, leaning against the hinge. See `PlanningModel`."""
        goal = self.goal_state if door_angle is None else self.state(self.model.on_the_way(door_angle), np.zeros(3))
        return leaning(self.model, goal, hinge)

    def impossible(self, hinge: Hinge, start: Array) -> tuple[PlanStatus, str] | None:
        """Whether the door resists by more than the vehicle can push. See `PlanningModel`."""
        return too_stiff(self.model, hinge, float(start[3]), self._largest)

    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        """Share of the thrust along the door's normal. See `PlanningModel`."""
        return push_along_normal(self.model, *self.reduced(states, inputs))
