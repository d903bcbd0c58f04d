r"""The planner's simplified dynamics (the paper's): attitude and arm obey the inputs, the thrust's push moves the door.

.. math::
    \dot\Phi = W(\Phi)\,\Omega,\quad
    \ddot\alpha = \frac{1}{I_D}\,J^T (f_t R e_3 - m_A g e_3) - \frac{\tau}{I_D},\quad
    \dot H = \dot H_d

with the contact's lever J, −D_V n_D in the paper, where it is horizontal, and the hinge's torque
:math:`\tau = b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) + \tau_d + G(\alpha)`.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.kinematics.numbers import Numbers
from doorman.kinematics.symbols import euler_rates
from doorman.kinematics.tied_task import TiedTask
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern


class QuasiStaticTask(TiedTask):
    """x = [Φ, α, α̇, H], u = [f_t, Ω, Ḣ_d]; I_D is `door.moving_inertia`. See `TiedTask`."""

    def __init__(self, pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> None:
        super().__init__(pattern, point_names, numbers)
        self.body_rates = ca.SX.sym("body_rate", 3)
        self.state = ca.vertcat(self.attitude, self.door_angle, self.door_rate, self.arm_angles)
        self.inputs = ca.vertcat(self.thrust, self.body_rates, self.arm_rates)
        if "actuation.side" in numbers.sizes:
            self.inputs = ca.vertcat(self.inputs, self.side_force)

    @property
    def derivative(self) -> Any:
        """ẋ, (5 + n, 1)."""
        torque = ca.dot(self.leaf.lever_in_heading, self.rotors_in_heading) - self.lifted - self.hinge_torque
        acceleration = torque / self.door.moving_inertia
        return ca.vertcat(euler_rates(self.attitude, self.body_rates), self.door_rate, acceleration, self.arm_rates)
