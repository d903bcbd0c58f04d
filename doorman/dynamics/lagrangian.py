r"""The coupled equations of motion of vehicle and door (the paper's Lagrangian model), the arm locked within them.

The contact has the lever J with the slope :math:`J' = dJ/d\alpha = o\,n_D - D_V r` (o = 0 in the paper, r along the leaf). With
the vertical k in body axes and the tip's place :math:`e = d - c` from the centre of mass c, the acceleration of c and the force
of the door on the tip are

.. math::
    a = \ddot\alpha J + \dot\alpha^2 J' + e\times\dot\Omega - \Omega\times(\Omega\times e),\quad
    w = m_A a - f_t e_3 + m_A g\,k

and the equations of motion, the Lagrange equations of q = [Φ, α] multiplied by :math:`[W^T, 1]`, are

.. math::
    I_A\dot\Omega + \Omega\times I_A\Omega = T - c\times f_t e_3 + e\times w,\quad I_D\ddot\alpha = -J^T w - \tau

with :math:`I_A` about c. The paper's arm has no mass: c = 0, and :math:`I_A` is the same in all postures. Else both follow the
posture. The mass matrix is :math:`\begin{bmatrix} I_A + m_A(e^Te - ee^T) & g\\ g^T & I_D + m_A J^TJ\end{bmatrix}` with
:math:`g = m_A J\times e`; its last pivot is constant, so that only a 3 × 3 matrix is left to invert. The arm moves slowly,
as the paper assumes: d and c enter, their rates do not.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from doorman.kinematics.numbers import Numbers
from doorman.kinematics.symbols import body_rates, euler_rates, symmetric
from doorman.kinematics.tied_task import TiedTask
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern


def inverse_of_symmetric(matrix: Any) -> Any:
    """Inverse of a symmetric matrix by its cofactors."""
    xx, xy, xz, yy, yz, zz = (matrix[i, j] for i in range(3) for j in range(i, 3))
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    d, e, f = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    return ca.vertcat(ca.horzcat(a, b, c), ca.horzcat(b, d, e), ca.horzcat(c, e, f)) / (xx * a + xy * b + xz * c)


class LagrangianTask(TiedTask):
    """x = [Φ, α, Φ̇, α̇, H], u = [f_t, T, Ḣ_d]; `vehicle.inertia` is I_A of an arm without mass: xx, xy, xz, yy, yz, zz."""

    def __init__(self, pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> None:
        super().__init__(pattern, point_names, numbers)
        self.euler_rates = ca.SX.sym("euler_rate", 3)
        self.torque = ca.SX.sym("torque", 3)
        self.body_rates = body_rates(self.attitude, self.euler_rates)
        self.state = ca.vertcat(self.attitude, self.door_angle, self.euler_rates, self.door_rate, self.arm_angles)
        self.inputs = ca.vertcat(self.thrust, self.torque, self.arm_rates)

    @cached_property
    def inertia(self) -> Any:
        """I_A about the centre of mass in body axes, (3, 3) [kg m²]."""
        return symmetric(self.vehicle.inertia) if self._bodies is None else self._bodies.inertia()

    @cached_property
    def tip_from_center(self) -> Any:
        """The tip from the centre of mass, e, (3, 1) [m]."""
        return self.tip_in_body if self._bodies is None else self.tip_in_body - self.center_of_mass

    @cached_property
    def _lever(self) -> Any:
        """J, body axes [m]."""
        return self.tilt_rotation.T @ self.leaf.lever_in_heading

    def _force_on_tip(self, turning: Any, swinging: Any) -> Any:
        """W for Ω̇ and α̈."""
        rates, tip, contact = self.body_rates, self.tip_from_center, self.contact
        bent = contact.offset * self.leaf.normal_in_heading - contact.distance_from_hinge * self.leaf.leaf_in_heading
        of_contact = swinging * self._lever + self.door_rate**2 * (self.tilt_rotation.T @ bent)
        of_tip = ca.cross(turning, tip) + ca.cross(rates, ca.cross(rates, tip))
        lifted = self.weight * self.tilt_rotation.T[:, 2] - ca.vertcat(0, 0, self.thrust)
        return self.vehicle.mass * (of_contact - of_tip) + lifted

    @cached_property
    def accelerations(self) -> tuple[Any, Any]:
        """Ω̇, (3, 1), body frame, and α̈ [rad/s²]."""
        tip, mass, contact = self.tip_from_center, self.vehicle.mass, self.contact
        drift = self._force_on_tip(ca.SX.zeros(3), 0)
        gyroscopic = ca.cross(self.body_rates, self.inertia @ self.body_rates)
        moment = self.torque + ca.cross(tip, drift) - gyroscopic
        if self._bodies is not None:
            moment -= ca.cross(self.center_of_mass, ca.vertcat(0, 0, self.thrust))
        torque = -ca.dot(self._lever, drift) - self.hinge_torque
        swing = 1 / (self.door.inertia + mass * (contact.distance_from_hinge**2 + contact.offset**2))
        coupling = mass * ca.cross(self._lever, tip)
        rotational = self.inertia + mass * (ca.dot(tip, tip) * ca.SX.eye(3) - tip @ tip.T)
        inverse = inverse_of_symmetric(rotational - swing * (coupling @ coupling.T))
        turning = inverse @ (moment - swing * torque * coupling)
        return turning, swing * (torque - ca.dot(coupling, turning))

    @cached_property
    def contact_force(self) -> Any:
        """Force of the tip on the door, (3, 1), world frame [N]."""
        return -self.rotation @ self._force_on_tip(*self.accelerations)

    @property
    def derivative(self) -> Any:
        """ẋ, (8 + n, 1)."""
        turning, swinging = self.accelerations
        bias = ca.jtimes(self.body_rates, self.attitude, self.euler_rates)
        bent = euler_rates(self.attitude, turning - bias)
        return ca.vertcat(self.euler_rates, self.door_rate, bent, swinging, self.arm_rates)
