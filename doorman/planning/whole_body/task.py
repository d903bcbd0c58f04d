r"""One problem from free flight to contact: vehicle, arm and mechanism in symbols, the tip on the face by a compliant contact.

States :math:`x = [P, \Phi, V, \dot\Phi, q, \dot q, H]`, inputs :math:`u = [f, \phi_c, \theta_c, \tau_z, \dot H]`.
The tip is at :math:`p_t = P + R\,d(H)`. With the leaf's p(q), outward n(q) and J (`leaf_symbols`), q = α, the tip's depth in
the face and the speed at which it closes are

.. math:: \delta = -n^T(p_t - p(q)),\qquad v = \dot p_t - J(p_t)\,\dot q,\qquad \dot\delta = -n^T v .

The contact is a spring and a damper that fade in over ε. In the plane of the face, along (1) and up (2), the tip gives by
about :math:`e_0` before it slips, from where it sticks now, with e the way from there:

.. math::
    \sigma = \tfrac12\big(\delta + \sqrt{\delta^2 + 4\epsilon^2}\big),\quad
    \lambda = k\,\sigma + c\,\frac{\sigma}{\sigma + \epsilon}\,\dot\delta,\quad
    F = -\lambda n + \mu\lambda\,\frac{e}{\sqrt{e^2 + e_0^2}} + c_t\frac{\sigma}{\sigma + \epsilon}\,v_t

is the tip's force on the mechanism. A tip that grips by g, from 0 to 1, is tied by that share: in place of these it has
g times a spring and a damper in all three directions,

.. math::
    F = -\lambda n + F_t,\quad
    \lambda = k\big((1-g)\,\sigma + g\,\delta\big) + c\,\gamma\,\dot\delta,\quad
    F_t = (1-g)\,\frac{\mu\lambda\,e}{\sqrt{e^2 + e_0^2}} + g\,k\,e + c_t\,\gamma\,v_t,\quad
    \gamma = g + (1-g)\,\frac{\sigma}{\sigma+\epsilon}

with e from where it is held. Nothing is compiled as it closes: g is a number. Then

.. math::
    m\,a &= f R e_3 - m g e_3 + F_w - F,\\
    \ddot\phi &= \kappa_r\big(\kappa_a(\phi_c + M_x/s_x + b_x - \phi) - \dot\phi\big)\ \text{(and θ with y)},\\
    I_z\ddot\psi &= \tau_z - e_3^T\big((p_t - P - R\,c)\times F\big),\\
    I\ddot q &= J(p_t)^T F - b\dot q - \tau_c\tanh(\dot q/\epsilon_q) - k_q(q - q_r) - \tau - G(q) .

with the acceleration a and the place c(H) of the centre of mass. An arm without mass has c = 0 and :math:`\dot V = a`; else
:math:`\dot V = a - R\big(\dot\Omega\times c + \Omega\times(\Omega\times c)\big)`. The attitude loop holds the static moment
:math:`c\times f e_3`, which `static_moment` bounds.

Roll and pitch reach what is commanded with the lag of the vehicle's attitude loop, :math:`\kappa_a` and :math:`\kappa_r`. The
moment :math:`M = -R^T\big((p_t - P - R\,c)\times F\big)` turns the vehicle beside it by the loop's stiffness s, and b is what
else does (`control.tilt_observer`). Yaw has no such loop that can be relied on: rotors make little torque about the vertical, so
:math:`\tau_z` is bounded, and the moment of the tip's force is in the equation.

Friction that would stop the leaf within a step h is taken at the step's end instead: of the rate that the leaf would have without
it, no more than :math:`h\tau_c/I` is lost, rounded by ε.

A fully actuated vehicle has two inputs more, :math:`f_x` and :math:`f_y`, and :math:`R\,[f_x, f_y, f]^T` in place of
:math:`f R e_3`; its numbers are `actuation.*`.

There are no phases. `reference.*` and `weight.*` are numbers: approach, touch, swing, hold and letting go are other numbers of
the same problem. A step is semi-implicit: rates change first, and places with the new rates.

**A leaf that can be stopped.** Let the hinge resist by at least :math:`\hat\tau` while it opens, and let
:math:`a = \eta\hat\tau/I`. In :math:`S = \{\tfrac12\dot q^2 \le a g\}`, with g the way to the goal, every force
:math:`\lambda \le (1 - \eta)\hat\tau/\lvert J^Tn\rvert` keeps the leaf in S until it rests, and so does no contact at all.
*Sketch:* the leaf's own equation gives
:math:`I\,\mathrm{d}\lvert\dot q\rvert/\mathrm{d}t \le \lvert J^Tn\rvert\lambda - \hat\tau \le -\eta\hat\tau`, thus
:math:`\tfrac12\dot q^2 - a g` does not grow. The vehicle's mass does not enter: a leaf that the tip does not follow leaves it
behind. The force of the tip follows a command by the attitude's lag, so that a state on the border of S needs that much room.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from doorman.collision.rows.kind import disc_across
from doorman.dynamics.tip_on_face import TipOnFace
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.symbols import body_rates
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.ocp.symbolic_model import SymbolicModel


class WholeBodyTask(TipOnFace):
    """Vehicle, arm, leaf and contact. See `Task`."""

    def __init__(self, pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> None:
        super().__init__(pattern, point_names, numbers)
        symbol = ca.SX.sym
        self.position, self.velocity = symbol("position", 3), symbol("velocity", 3)
        self.attitude_rates = symbol("attitude_rate", 3)
        self.tilt_command, self.yaw_torque = symbol("tilt_command", 2), symbol("yaw_torque")
        self.state = ca.vertcat(
            self.position, self.attitude, self.velocity, self.attitude_rates, self.door_angle, self.door_rate,
            self.arm_angles,
        )  # fmt: skip
        side = [self.side_force] if "actuation.side" in numbers.sizes else []
        self.inputs = ca.vertcat(self.thrust, self.tilt_command, self.yaw_torque, self.arm_rates, *side)

    @cached_property
    def body_rates(self) -> Any:
        """Ω, (3, 1), body frame [rad/s]."""
        return body_rates(self.attitude, self.attitude_rates)

    @cached_property
    def position_from_hinge(self) -> Any:
        """P − P_h of O_B, (3, 1) [m]."""
        return self.position - self.door.hinge_position

    @cached_property
    def before_leaf(self) -> Any:
        """Distance of O_B from the plane of the leaf's face [m]."""
        return ca.dot(self.contact_normal, self.contact_point - self.position)

    @cached_property
    def half_width(self) -> Any:
        """Half of what the rotor disc takes up across the doorway, wherever it tilts [m]."""
        return disc_across(self, self.door.along)

    @cached_property
    def _contact_torque(self) -> Any:
        """Torque of the leaf on the vehicle about its centre of mass, world axes, (3, 1) [N m]."""
        reach = self.tip_position - self.position
        if self._bodies is not None:
            reach -= self.rotation @ self.center_of_mass
        return -ca.cross(reach, self.force)

    @property
    def contact_yaw_torque(self) -> Any:
        """Torque of the leaf on the vehicle about the vertical through its centre of mass [N m]."""
        return self._contact_torque[2]

    @property
    def turned_by_contact(self) -> Any:
        """Roll and pitch beside what is commanded, by the leaf's torque on the vehicle, (2, 1) [rad]."""
        return (self.rotation.T @ self._contact_torque)[:2] / self.vehicle.tilt_stiffness

    @cached_property
    def rates_of_change(self) -> Any:
        """Accelerations [V̇, Φ̈, q̈], (7, 1)."""
        vehicle, door = self.vehicle, self.door
        acceleration = (
            self.rotors_in_heading - ca.vertcat(0, 0, self.weight) + vehicle.wind - self.force
        ) / vehicle.mass
        wanted = vehicle.attitude_gain * (
            self.tilt_command + self.turned_by_contact + vehicle.tilt_offset - self.attitude[:2]
        )
        tilting = vehicle.rate_gain * (wanted - self.attitude_rates[:2])
        turning = (self.yaw_torque + self.contact_yaw_torque) / vehicle.yaw_inertia
        pushed = ca.dot(self.lever_of_tip, self.force)
        resists = door.damping * self.door_rate + self._friction(pushed) + self.hinge_torque_at_rest
        acceleration -= self._around_the_center(ca.vertcat(tilting, turning))
        return ca.vertcat(acceleration, tilting, turning, (pushed - resists) / door.inertia)

    def _friction(self, pushed: Any) -> Any:
        """Friction of the hinge [N m]: by its rate, or where that would oscillate in a step, by the rate at the step's end."""
        door = self.door
        per_rate = door.inertia / self.plan.time_step
        free = self.door_rate + (pushed - self.hinge_torque_at_rest) / per_rate
        stops, rounding = door.friction / per_rate, 0.5 * door.friction_rate
        held = 0.5 * (ca.sqrt((free + stops) ** 2 + rounding**2) - ca.sqrt((free - stops) ** 2 + rounding**2))
        slides = door.friction * ca.tanh(self.door_rate / door.friction_rate)
        return (1 - door.sticks) * slides + door.sticks * per_rate * held

    def _around_the_center(self, bent: Any) -> Any:
        """Acceleration of the centre of mass less that of O_B, for Φ̈, (3, 1), world frame [m/s²]."""
        if self._bodies is None:
            return ca.SX(3, 1)
        center, rates = self.center_of_mass, self.body_rates
        turning = body_rates(self.attitude, bent) + ca.jtimes(rates, self.attitude, self.attitude_rates)
        return self.rotation @ (ca.cross(turning, center) + ca.cross(rates, ca.cross(rates, center)))

    @property
    def next_state(self) -> Any:
        """x⁺ by a semi-implicit Euler step: rates first, then with them what they change, (nx, 1)."""
        h, change = self.plan.time_step, self.rates_of_change
        velocity, attitude_rates = self.velocity + h * change[:3], self.attitude_rates + h * change[3:6]
        door_rate = self.door_rate + h * change[6]
        return ca.vertcat(
            self.position + h * velocity, self.attitude + h * attitude_rates, velocity, attitude_rates,
            self.door_angle + h * door_rate, door_rate, self.arm_angles + h * self.arm_rates,
        )  # fmt: skip

    @cached_property
    def to_go(self) -> Any:
        """Way from α to the goal, positive before it [rad]."""
        return self.reference.sense * (self.reference.joint - self.door_angle)

    def symbolic_model(self, timed: bool = False) -> SymbolicModel:
        """No step leads through the poles of the Euler angles."""
        return SymbolicModel(
            self.state, self.inputs, self.next_state, parameters=self.parameters, integrator="discrete",
            node_parameters=self.time if timed else None, domain=ca.cos(self.attitude[1]),
        )  # fmt: skip
