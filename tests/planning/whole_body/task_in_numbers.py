"""The whole-body task of a model in numbers: its expressions as functions, and states with the tip at the leaf."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.model import Model
from doorman.planning.whole_body.contact import whole_body_state
from doorman.planning.whole_body.numbers import whole_body_numbers
from doorman.planning.whole_body.task import WholeBodyTask

Array = np.ndarray


class TaskInNumbers:
    def __init__(self, model: Model, numbers: Numbers | None = None) -> None:
        self.model, self.numbers = model, numbers or whole_body_numbers(model)
        pattern, _ = ArmPattern.of(model.vehicle.arm)
        self.task = WholeBodyTask(pattern, model.vehicle.point_names, self.numbers)

    @property
    def hover(self) -> Array:
        return np.array([self.model.vehicle.weight, *np.zeros(3 + self.model.n_arm)])

    def function(self, expression: object) -> Callable[..., Array]:
        """An expression as a function of the state, of inputs, by default those of a hover, and of numbers."""
        task = self.task
        compiled = ca.Function("f", [task.state, task.inputs, task.parameters], [expression])

        def value(x: Array, *given: Array | Numbers) -> Array:
            numbers = given[-1] if given else self.numbers
            return np.array(compiled(x, given[0] if len(given) > 1 else self.hover, numbers.vector)).squeeze()

        return value

    def at_the_leaf(
        self,
        depth: float,
        angle: float = 1.2,
        attitude: Array | None = None,
        rate: float = 0.0,
        off: Array | float = 0.0,
    ) -> Array:
        """At rest, with the tip this deep in the leaf at the contact point, or off it."""
        posture = self.model.on_the_way(angle)
        attitude = posture[:3] if attitude is None else attitude
        place = self.model.coupling.vehicle_position(attitude, angle, posture[5:]) + off
        place = place + depth * self.model.door.normal(angle)
        return whole_body_state(place, attitude, np.zeros(3), np.zeros(3), angle, rate, posture[5:])
