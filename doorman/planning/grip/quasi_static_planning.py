"""The simplified dynamics as a model to plan with: its states and inputs are the reduced ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.planning.composition import NO_EXTRAS, NOTHING, Extras
from doorman.planning.grip.door_problem import door_numbers, door_problem
from doorman.planning.grip.push import leaning, push_along_normal
from doorman.planning.hinge import Hinge
from doorman.planning.model_base import Motion, PlanningModel


class TiedPlanning(PlanningModel):
    """A model whose tip is tied to the contact point: where the vehicle is follows from attitude, arm and door."""

    def fitted(
        self, hinge: Hinge, margin: float, start: Array, given: Mapping[str, ArrayLike] = NOTHING, door_angle: float | None = None
    ) -> Numbers:  # fmt: skip
        """The scenario's numbers with those of the hinge and the margin; a start changes none. See `PlanningModel`."""
        known = {**hinge.numbers(), "door.moving_inertia": hinge.inertia, "limits.margin": margin}
        return self.numbers.replaced({**known, **given})

    def goal(self, start: Array, hinge: Hinge, door_angle: float | None = None) -> Array:
        """The scenario's goal, or a place on the way there, leaning against the hinge. See `PlanningModel`."""
        goal = self.goal_state if door_angle is None else self.state(self.model.on_the_way(door_angle), np.zeros(3))
        return leaning(self.model, goal, hinge)

    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        """Share of the thrust along the door's normal. See `PlanningModel`."""
        return push_along_normal(self.model, *self.reduced(states, inputs))


class QuasiStaticPlanning(TiedPlanning):
    """x = [Φ, α, α̇, H], u = [f_t, Ω, Ḣ_d]; see `PlanningModel`."""

    def __init__(self, model: Model) -> None:
        states = ("roll", "pitch", "yaw", "door angle", "door rate")
        inputs = ("thrust", "body rate x", "body rate y", "body rate z")
        super().__init__(model, states, inputs, door_numbers(model))

    def problem(self, extras: Extras = NO_EXTRAS, numbers: Numbers | None = None) -> Problem:
        """The paper's problem. See `PlanningModel`."""
        return door_problem(self.model, numbers or self.numbers, extras)

    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        """The reduced state itself: body rates are inputs here. See `PlanningModel`."""
        return np.array(reduced, dtype=np.float64)

    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        """States and inputs themselves. See `PlanningModel`."""
        return states, inputs

    def swing(self, disturbance: float) -> Callable[[Array, Array], Array]:
        r"""This model with the inertia that a push really moves, :math:`I_D + m_A D_V^2`. See `PlanningModel`."""
        model = self.model
        moving = model.door.inertia + model.vehicle.mass * model.coupling.lever_length**2
        known = {"door.moving_inertia": moving, "door.friction": 0.0, "door.disturbance": disturbance}
        if model.actuation.fully:
            return Motion(self.problem(numbers=self.numbers.replaced(known)))
        return model.reduced.with_numbers(known).step
