"""The full Lagrangian dynamics as a model to plan with."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import body_rates_of, euler_rate_matrix, regular_state
from doorman.kinematics.urdf.robot import frozen
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.options import SolverOptions
from doorman.planning.composition import NO_EXTRAS, NOTHING, Extras
from doorman.planning.grip.lagrangian_problem import at_rest, lagrangian_numbers, lagrangian_problem
from doorman.planning.grip.quasi_static_planning import QuasiStaticPlanning
from doorman.planning.hinge import Hinge
from doorman.planning.own_motion import Motion


class LagrangianPlanning(QuasiStaticPlanning):
    """x = [Φ, α, Φ̇, α̇, H], u = [f_t, T, Ḣ_d]; with rows, goal and forces of the simplified dynamics. See `PlanningModel`."""

    def __init__(self, model: Model) -> None:
        self.model = model
        joints = model.vehicle.joint_names
        angles = ("roll", "pitch", "yaw", "door angle")
        self.state_names = (*angles, "roll rate", "pitch rate", "yaw rate", "door rate", *joints)
        self.input_names = ("thrust", "torque x", "torque y", "torque z", *(f"rate of {j}" for j in joints))
        self.start_state = frozen(at_rest(model.start_state))
        self.goal_state = frozen(at_rest(model.goal_state))
        self.hover_input = model.hover_input
        self.moved_mass = model.vehicle.mass
        self.headings: tuple[tuple[int, int], ...] = ()
        self.tolerance = SolverOptions().feasibility
        self.numbers = lagrangian_numbers(model)

    def check_state(self, state: ArrayLike, field: str = "state") -> Array:
        """A state as a contiguous float array. See `PlanningModel`."""
        return regular_state(state, 8 + self.model.n_arm, field)

    def problem(self, extras: Extras = NO_EXTRAS) -> Problem:
        """The door problem with full dynamics. See `PlanningModel`."""
        return lagrangian_problem(self.model, self.numbers, extras)

    def fitted(
        self, hinge: Hinge, margin: float, start: Array, given: Mapping[str, ArrayLike] = NOTHING, door_angle: float | None = None
    ) -> Numbers:  # fmt: skip
        """The scenario's numbers with those of the hinge and the margin; a start changes none. See `PlanningModel`."""
        return self.numbers.replaced({**hinge.numbers(), "limits.margin": margin, **given})

    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        r"""The reduced state with :math:`\dot\Phi = W(\Phi)\,\Omega`. See `PlanningModel`."""
        x = np.asarray(reduced, dtype=np.float64)
        return np.concatenate([x[:4], euler_rate_matrix(x[:3]) @ np.asarray(body_rates), x[4:]])

    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        r"""States without Φ̇, inputs with :math:`\Omega = W^{-1}\dot\Phi` for the torques. See `PlanningModel`."""
        x, u = np.array(states, ndmin=2), np.array(inputs, ndmin=2)
        u[:, 1:4] = body_rates_of(x[: len(u), :3], x[: len(u), 4:7])
        reduced = np.delete(x, (4, 5, 6), axis=1)
        return (reduced if states.ndim == 2 else reduced[0]), u.reshape(inputs.shape)

    def swing(self, disturbance: float) -> Callable[[Array, Array], Array]:
        """The full dynamics, without friction in the hinge. See `PlanningModel`."""
        numbers = self.numbers.replaced({"door.disturbance": disturbance, "door.friction": 0.0})
        return Motion(lagrangian_problem(self.model, numbers))
