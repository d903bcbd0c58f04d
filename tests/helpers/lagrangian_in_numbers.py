r"""The full Lagrangian model of vehicle and door in numbers: x = [Φ, α, Φ̇, α̇, H], u = [f_t, T, Ḣ_d] (the paper's dynamics).

.. math::
    M_q\ddot q + C_q\dot q + G_q = J_t^T R e_3 f_t + J_r^T T - J_\alpha^T\tau,\quad \dot H = \dot H_d,\quad
    M_q = J_t^T m_A J_t + J_r^T I_A J_r + J_\alpha^T I_D J_\alpha

with the hinge's torque τ of `Task.hinge_torque`. CasADi evaluates the symbols of `LagrangianTask`.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from attitude_matrices import body_rate_matrix, skew
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.dynamics.lagrangian import LagrangianTask
from doorman.kinematics.coupling import Coupling
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.model import Model
from doorman.planning.grip.lagrangian_problem import inertia_numbers


@cache
def _functions(pattern: ArmPattern, point_names: tuple[str, ...], sizes: tuple[tuple[str, int], ...]) -> Any:
    """CasADi functions of x, u and the numbers; of the time step, too, where they need it."""
    task = LagrangianTask(pattern, point_names, Numbers({name: np.zeros(size) for name, size in sizes}))
    model, given = task.symbolic_model(), [task.state, task.inputs, task.parameters]
    jacobian = ca.jacobian(model.step, ca.vertcat(task.state, task.inputs))
    expressions = {"derivative": (task.derivative, []), "contact_force": (task.contact_force, []),
                   "step": (model.step, [model.time_step]), "step_jacobian": (jacobian, [model.time_step])}  # fmt: skip
    return {name: ca.Function(name, [*given, *more], [each]) for name, (each, more) in expressions.items()}


def translation_jacobian(coupling: Coupling, attitude: ArrayLike, door_angle: float, arm_angles: ArrayLike) -> Array:
    r"""J_t of :math:`\dot P = J_t\dot q - R\dot d`: :math:`J_t = [R\,\hat d\,W^{-1},\ J]`."""
    turned = (
        rotation_body_to_world(attitude) @ skew(coupling.vehicle.tip_position(arm_angles)) @ body_rate_matrix(attitude)
    )
    return np.column_stack([turned, coupling.door.lever(door_angle, coupling.distance_from_hinge)])


def rotation_jacobian(attitude: ArrayLike) -> Array:
    r"""J_r of :math:`\Omega = J_r\dot q`: :math:`J_r = [W^{-1}(\Phi),\ 0]`."""
    return np.hstack([body_rate_matrix(attitude), np.zeros((3, 1))])


class LagrangianModel:
    """Full dynamics of vehicle and door tied at the tip, arm locked: x = [φ, θ, ψ, α, φ̇, θ̇, ψ̇, α̇, η…], u = [f_t, T, Ḣ_d]."""

    def __init__(
        self,
        coupling: Coupling,
        time_step: float,
        *,
        disturbance: float = 0.0,
    ) -> None:
        self.coupling = coupling
        self.time_step = float(time_step)
        self.disturbance = float(disturbance)
        self.n_arm = coupling.vehicle.n_arm
        self.nx = 8 + self.n_arm
        self.nu = 4 + self.n_arm
        self._pattern, _ = ArmPattern.of(coupling.vehicle.arm)
        numbers = task_numbers(coupling.vehicle, coupling.door, coupling.distance_from_hinge, coupling.height)
        self.numbers = numbers.replaced({"door.disturbance": self.disturbance}).and_also(
            inertia_numbers(coupling.vehicle)
        )
        """Of the symbolic task, by name."""

    def _value(self, name: str, x: Array, u: Array, *time_step: float) -> Array:
        functions = _functions(self._pattern, self.coupling.vehicle.point_names, tuple(self.numbers.sizes.items()))
        return np.asarray(functions[name](x, u, self.numbers.vector, *time_step))

    def contact_force(self, state: ArrayLike, inputs: ArrayLike) -> Array:
        r"""Force of the tip on the door, :math:`f_t R e_3 - m_A g e_3 - m_A a` with the centre of mass' acceleration a."""
        x, u = np.asarray(state, dtype=float), np.asarray(inputs, dtype=float)
        return self._value("contact_force", x, u)[:, 0]

    def derivative(self, state: ArrayLike, inputs: ArrayLike) -> Array:
        """Time derivative of the state."""
        x, u = np.asarray(state, dtype=float), np.asarray(inputs, dtype=float)
        return self._value("derivative", x, u)[:, 0]

    def step(self, state: ArrayLike, inputs: ArrayLike) -> Array:
        """One RK4 step over the time step."""
        x, u = np.asarray(state, dtype=float), np.asarray(inputs, dtype=float)
        return self._value("step", x, u, self.time_step)[:, 0]

    def step_jacobian(self, state: ArrayLike, inputs: ArrayLike) -> tuple[Array, Array]:
        """Exact sensitivities A, B of `step`."""
        x, u = np.asarray(state, dtype=float), np.asarray(inputs, dtype=float)
        jacobian = self._value("step_jacobian", x, u, self.time_step)
        return jacobian[:, : self.nx], jacobian[:, self.nx :]


def in_numbers(model: Model) -> LagrangianModel:
    """Full dynamics of a scenario."""
    return LagrangianModel(model.coupling, model.scenario.planner.time_step)
