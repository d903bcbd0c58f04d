"""The full Lagrangian dynamics as a model to plan with."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import body_rates_of, euler_rates
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.planning.composition import NO_EXTRAS, Extras
from doorman.planning.grip.lagrangian_problem import lagrangian_numbers, lagrangian_problem
from doorman.planning.grip.quasi_static_planning import TiedPlanning


class LagrangianPlanning(TiedPlanning):
    """x = [Φ, α, Φ̇, α̇, H], u = [f_t, T, Ḣ_d]; see `PlanningModel`."""

    def __init__(self, model: Model) -> None:
        states = ("roll", "pitch", "yaw", "door angle", "roll rate", "pitch rate", "yaw rate", "door rate")
        inputs = ("thrust", "torque x", "torque y", "torque z")
        super().__init__(model, states, inputs, lagrangian_numbers(model))
        self.moved_mass = model.vehicle.mass

    def problem(self, extras: Extras = NO_EXTRAS, numbers: Numbers | None = None) -> Problem:
        """The door problem with full dynamics. See `PlanningModel`."""
        return lagrangian_problem(self.model, numbers or self.numbers, extras)

    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        r"""The reduced state with :math:`\dot\Phi = W(\Phi)\,\Omega`. See `PlanningModel`."""
        x = np.asarray(reduced, dtype=np.float64)
        return np.concatenate([x[:4], euler_rates(x[:3], np.asarray(body_rates)), x[4:]])

    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        r"""States without Φ̇, inputs with :math:`\Omega = W^{-1}\dot\Phi` for the torques. See `PlanningModel`."""
        x, u = np.array(states, ndmin=2), np.array(inputs, ndmin=2)
        u[:, 1:4] = body_rates_of(x[: len(u), :3], x[: len(u), 4:7])
        reduced = np.delete(x, (4, 5, 6), axis=1)
        return (reduced if states.ndim == 2 else reduced[0]), u.reshape(inputs.shape)
