r"""The quasi-static task with a tip that can only push: vehicle and leaf swing as one.

With :math:`I_e = I_D + m_A D_V^2` (`door.moving_inertia`) and the push :math:`F_n` that the attitude by itself makes of a thrust
which carries the weight, :math:`F_n = m_A g\,(n_D^T R e_3)/(e_3^T R e_3)`,

.. math::
    \lambda_n = \frac{I_D F_n - m_A D_V\tau}{I_e},\qquad
    \lambda_t = m_A g\,\frac{c^T R e_3}{e_3^T R e_3} + m_A D_V\dot\alpha^2

are the tip's normal force on the leaf and its force along the leaf's direction c.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from doorman.dynamics.quasi_static import QuasiStaticTask


class PushTask(QuasiStaticTask):
    """Forces of the tip as functions of the state. See `Task`."""

    @cached_property
    def attitude_push(self) -> Any:
        """F_n [N]."""
        up = self.tilt_rotation[:, 2]
        return self.weight * ca.dot(self.normal_in_heading, up) / up[2]

    @cached_property
    def normal_force(self) -> Any:
        """λ_n, positive where the tip presses [N]."""
        lever = self.contact.distance_from_hinge
        moved = self.door.inertia * self.attitude_push - self.vehicle.mass * lever * self.hinge_torque
        return moved / self.door.moving_inertia

    @cached_property
    def force_along_leaf(self) -> Any:
        """λ_t, positive from the hinge to the latch [N]."""
        up, lever = self.tilt_rotation[:, 2], self.contact.distance_from_hinge
        held = self.weight * ca.dot(self.leaf_in_heading, up) / up[2]
        return held + self.vehicle.mass * lever * self.door_rate**2

    @property
    def door_acceleration(self) -> Any:
        r"""−α̈ of a vehicle that keeps its height, positive where the door opens faster [rad/s²]."""
        torque = self.contact.distance_from_hinge * self.attitude_push + self.hinge_torque
        return torque / self.door.moving_inertia

    @cached_property
    def yaw_moment(self) -> Any:
        """Of the tip's force on the vehicle, about the vertical through O_B [N m]."""
        reach = self.tilt_rotation @ self.tip_in_body
        ahead, aside = ca.dot(reach, self.normal_in_heading), ca.dot(reach, self.leaf_in_heading)
        return aside * self.normal_force - ahead * self.force_along_leaf

    @property
    def lift(self) -> Any:
        """Thrust upwards beyond the weight, as a share of it."""
        return self.thrust / self.weight * self.tilt_rotation[2, 2] - 1
