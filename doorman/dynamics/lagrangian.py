r"""The coupled equations of motion of vehicle and door (the paper's Lagrangian model), the arm locked within them.

With the contact's lever J and its slope :math:`J' = dJ/d\alpha = o\,n_D - D_V c` (o = 0 in the paper) and the vertical k in body
axes, the acceleration of O_B and the force of the door on the tip are

.. math::
    a = \ddot\alpha J + \dot\alpha^2 J' + d\times\dot\Omega - \Omega\times(\Omega\times d),\quad
    w = m_A a - f_t e_3 + m_A g\,k

and the equations of motion, the Lagrange equations of q = [Φ, α] multiplied by :math:`[W^T, 1]`, are

.. math::
    I_A\dot\Omega + \Omega\times I_A\Omega = T + d\times w,\quad I_D\ddot\alpha = -J^T w - \tau.

Their mass matrix is :math:`\begin{bmatrix} I_A + m_A(d^Td - dd^T) & g\\ g^T & I_D + m_A J^TJ\end{bmatrix}` with
:math:`g = m_A J\times d`; its last pivot is constant, so that only a 3 × 3 matrix is left to invert. The arm moves slowly,
as the paper assumes: d enters, its rate does not.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from doorman.dynamics.small_matrices import inverse_of_symmetric
from doorman.kinematics.arm_pattern import ArmPattern
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.symbols import body_rates, euler_rates
from doorman.kinematics.task import Task


class LagrangianTask(Task):
    """x = [Φ, α, Φ̇, α̇, H], u = [f_t, T, Ḣ_d]; `vehicle.inertia` is I_A: xx, xy, xz, yy, yz, zz. See `Task`."""

    def __init__(self, pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> None:
        super().__init__(pattern, point_names, numbers)
        self.euler_rates = ca.SX.sym("euler_rate", 3)
        self.torque = ca.SX.sym("torque", 3)
        self.body_rates = body_rates(self.attitude, self.euler_rates)
        self.state = ca.vertcat(self.attitude, self.door_angle, self.euler_rates, self.door_rate, self.arm_angles)
        self.inputs = ca.vertcat(self.thrust, self.torque, self.arm_rates)

    @cached_property
    def inertia(self) -> Any:
        """I_A about O_B in body axes, (3, 3) [kg m²]."""
        xx, xy, xz, yy, yz, zz = ca.vertsplit(self.vehicle.inertia)
        return ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))

    @cached_property
    def _lever(self) -> Any:
        """J, body axes [m]."""
        return self.tilt_rotation.T @ self.lever_in_heading

    def _force_on_tip(self, turning: Any, swinging: Any) -> Any:
        """W for Ω̇ and α̈."""
        rates, tip, contact = self.body_rates, self.tip_in_body, self.contact
        bent = contact.offset * self.normal_in_heading - contact.distance_from_hinge * self.leaf_in_heading
        of_contact = swinging * self._lever + self.door_rate**2 * (self.tilt_rotation.T @ bent)
        of_tip = ca.cross(turning, tip) + ca.cross(rates, ca.cross(rates, tip))
        lifted = self.weight * self.tilt_rotation.T[:, 2] - ca.vertcat(0, 0, self.thrust)
        return self.vehicle.mass * (of_contact - of_tip) + lifted

    @cached_property
    def accelerations(self) -> tuple[Any, Any]:
        """Ω̇, (3, 1), body frame, and α̈ [rad/s²]."""
        tip, mass, contact = self.tip_in_body, self.vehicle.mass, self.contact
        drift = self._force_on_tip(ca.SX.zeros(3), 0)
        gyroscopic = ca.cross(self.body_rates, self.inertia @ self.body_rates)
        moment = self.torque + ca.cross(tip, drift) - gyroscopic
        torque = -ca.dot(self._lever, drift) - self.hinge_torque
        swing = 1 / (self.door.inertia + mass * (contact.distance_from_hinge**2 + contact.offset**2))
        coupling = mass * ca.cross(self._lever, tip)
        rotational = self.inertia + mass * (ca.dot(tip, tip) * ca.SX.eye(3) - tip @ tip.T)
        inverse = inverse_of_symmetric(rotational - swing * (coupling @ coupling.T))
        turning = inverse @ (moment - swing * torque * coupling)
        return turning, swing * (torque - ca.dot(coupling, turning))

    @cached_property
    def contact_force(self) -> Any:
        """Of the tip on the door, (3, 1), world frame [N]."""
        return -self.rotation @ self._force_on_tip(*self.accelerations)

    @property
    def derivative(self) -> Any:
        """ẋ, (8 + n, 1)."""
        turning, swinging = self.accelerations
        bias = ca.jtimes(self.body_rates, self.attitude, self.euler_rates)
        bent = euler_rates(self.attitude, turning - bias)
        return ca.vertcat(self.euler_rates, self.door_rate, bent, swinging, self.arm_rates)

    def evaluated(self) -> dict[str, Any]:
        """CasADi functions of x, u and the numbers: `derivative`, `contact_force`; of Δt, too: `step`, `step_jacobian`."""
        model, given = self.symbolic_model(), [self.state, self.inputs, self.parameters]
        jacobian = ca.jacobian(model.step, ca.vertcat(self.state, self.inputs))
        expressions = {"derivative": (self.derivative, []), "contact_force": (self.contact_force, []),
                       "step": (model.step, [model.time_step]), "step_jacobian": (jacobian, [model.time_step])}  # fmt: skip
        return {name: ca.Function(name, [*given, *more], [each]) for name, (each, more) in expressions.items()}
