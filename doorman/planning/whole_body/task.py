r"""One problem from free flight to contact: vehicle, arm and mechanism in symbols, the tip on the face by a compliant contact.

States :math:`x = [P, \Phi, V, \dot\Phi, q, \dot q, H]`, inputs :math:`u = [f, \phi_c, \theta_c, \tau_z, \dot H]`.
The tip is at :math:`p_t = P + R\,d(H)`. With the mechanism's p(q), n(q) and J (`mechanism`), the tip's depth in the face and the
speed at which it closes are

.. math:: \delta = -n^T(p_t - p(q)),\qquad v = \dot p_t - J(p_t)\,\dot q,\qquad \dot\delta = -n^T v .

The contact is a spring and a damper that fade in over ε. In the plane of the face, along (1) and up (2), the tip gives by
about :math:`e_0` before it slips, from where it sticks now, with e the way from there:

.. math::
    \sigma = \tfrac12\big(\delta + \sqrt{\delta^2 + 4\epsilon^2}\big),\quad
    \lambda = k\,\sigma + c\,\frac{\sigma}{\sigma + \epsilon}\,\dot\delta,\quad
    F = -\lambda n + \mu\lambda\,\frac{e}{\sqrt{e^2 + e_0^2}} + c_t\frac{\sigma}{\sigma + \epsilon}\,v_t

is the tip's force on the mechanism. Then

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
from types import SimpleNamespace
from typing import Any

import casadi as ca

from doorman.collision.surroundings import Surroundings
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.symbols import arm_points, body_rates
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.body_symbols import SymbolicBodies
from doorman.kinematics.vehicles.vehicle import GRAVITY
from doorman.ocp.symbolic_model import SymbolicModel
from doorman.planning.mechanism import Mechanism, mechanism_in_symbols
from doorman.planning.whole_body.planes import planes
from doorman.planning.whole_body.tip_on_face import TipOnFace

_LEAST_EXTENT = 1e-12
"""Under the root: a disc parallel to a plane has a slope, too."""


class WholeBodyTask(TipOnFace):
    """Named CasADi expressions of vehicle, arm, mechanism and contact, SI units, world frame unless the name says another.

    Args:
        pattern: Of the arm's constants.
        point_names: Of the arm's points, the tip last.
        numbers: Their names and sizes become symbols, see `whole_body_problem`.
        surroundings: What stands beside the door.
    """

    def __init__(
        self,
        pattern: ArmPattern,
        point_names: tuple[str, ...],
        numbers: Numbers,
        surroundings: Surroundings = "doorway",
    ) -> None:
        self._surroundings = surroundings
        n = pattern.n_joints
        symbol = ca.SX.sym
        self.time = symbol("time")
        self.position, self.velocity = symbol("position", 3), symbol("velocity", 3)
        self.attitude, self.attitude_rates = symbol("attitude", 3), symbol("attitude_rate", 3)
        self.joint, self.joint_rate = symbol("joint"), symbol("joint_rate")
        self.arm_angles, self.arm_rates = symbol("arm_angle", n), symbol("arm_rate", n)
        self.thrust, self.tilt_command, self.yaw_torque = (
            symbol("thrust"),
            symbol("tilt_command", 2),
            symbol("yaw_torque"),
        )
        self.state = ca.vertcat(
            self.position,
            self.attitude,
            self.velocity,
            self.attitude_rates,
            self.joint,
            self.joint_rate,
            self.arm_angles,
        )
        named = {name: symbol(name.replace(".", "_"), size) for name, size in numbers.sizes.items()}
        self.parameters = ca.vertcat(*named.values())
        self.of = {
            group: SimpleNamespace(
                **{name.partition(".")[2]: each for name, each in named.items() if name.startswith(f"{group}.")}
            )
            for group in {name.partition(".")[0] for name in named}
        }
        self.side_force = symbol("side_force", 2) if "actuation" in self.of else ca.SX(2, 1)
        self.inputs = ca.vertcat(
            self.thrust,
            self.tilt_command,
            self.yaw_torque,
            self.arm_rates,
            *([self.side_force] if "actuation" in self.of else []),
        )
        points = arm_points(pattern, named["arm.numbers"], self.arm_angles)
        self.points_in_body = dict(zip(point_names, points, strict=True))
        self.arm_side = 1 if pattern.above else -1
        self.fixed_points = tuple(name for name, parent in zip(point_names, pattern.parents, strict=True) if parent < 0)
        self.tip_in_body = points[-1]
        self._bodies: SymbolicBodies | None = None
        if "bodies" in self.of:
            self._bodies = SymbolicBodies(pattern, named["arm.numbers"], self.arm_angles, self.of["bodies"])
        self.balance = self.of.get("balance")
        """Numbers of `Balance`; None of an arm without mass."""
        self.mechanism: Mechanism = mechanism_in_symbols(self.of["mechanism"])

    @cached_property
    def center_of_mass(self) -> Any:
        """Centre of mass c of vehicle and arm, (3, 1), body frame [m]; O_B itself where the arm has no mass."""
        return ca.SX(3, 1) if self._bodies is None else self._bodies.center

    @cached_property
    def _contact_torque(self) -> Any:
        """Of the mechanism on the vehicle about its centre of mass, world axes, (3, 1) [N m]."""
        reach = self.tip - self.position
        if self._bodies is not None:
            reach -= self.rotation @ self.center_of_mass
        return -ca.cross(reach, self.force)

    @property
    def contact_yaw_torque(self) -> Any:
        """Torque of the mechanism on the vehicle about the vertical through its centre of mass [N m]."""
        return self._contact_torque[2]

    @property
    def turned_by_contact(self) -> Any:
        """Roll and pitch beside what is commanded, by the mechanism's torque on the vehicle, (2, 1) [rad]."""
        return (self.rotation.T @ self._contact_torque)[:2] / self.of["vehicle"].tilt_stiffness

    @cached_property
    def rates_of_change(self) -> Any:
        """Accelerations [V̇, Φ̈, q̈], (7, 1)."""
        vehicle, joint = self.of["vehicle"], self.of["mechanism"]
        weight = ca.vertcat(0, 0, vehicle.mass * GRAVITY)
        rotors = self.thrust * self.rotation[:, 2] + self.rotation[:, :2] @ self.side_force
        acceleration = (rotors - weight + vehicle.wind - self.force) / vehicle.mass
        wanted = vehicle.attitude_gain * (
            self.tilt_command + self.turned_by_contact + vehicle.tilt_offset - self.attitude[:2]
        )
        tilting = vehicle.rate_gain * (wanted - self.attitude_rates[:2])
        turning = (self.yaw_torque + self.contact_yaw_torque) / vehicle.yaw_inertia
        pushed = ca.dot(self.mechanism.lever(self.tip), self.force)
        resists = (
            joint.damping * self.joint_rate + self._friction(pushed)
            + joint.stiffness * (self.joint - joint.rest) + joint.torque + self.weight_torque
        )  # fmt: skip
        acceleration -= self._around_the_center(ca.vertcat(tilting, turning))
        return ca.vertcat(acceleration, tilting, turning, (pushed - resists) / joint.inertia)

    def _friction(self, pushed: Any) -> Any:
        """Of the joint [N m, or N]: by its rate, or where that would oscillate in a step, by the rate at the step's end."""
        joint = self.of["mechanism"]
        per_rate = joint.inertia / self.of["plan"].time_step
        drives = pushed - joint.stiffness * (self.joint - joint.rest) - joint.torque - self.weight_torque
        free, stops, rounding = (
            self.joint_rate + drives / per_rate,
            joint.friction / per_rate,
            0.5 * joint.friction_rate,
        )
        held = 0.5 * (ca.sqrt((free + stops) ** 2 + rounding**2) - ca.sqrt((free - stops) ** 2 + rounding**2))
        slides = joint.friction * ca.tanh(self.joint_rate / joint.friction_rate)
        return (1 - joint.sticks) * slides + joint.sticks * per_rate * held

    @property
    def weight_torque(self) -> Any:
        """G of the leaf's weight, in the sense of damping; 0 about a vertical [N m, or N]."""
        leaf = self.of["mechanism"]
        return self.mechanism.weight_torque(self.joint, leaf.center, leaf.weight) if hasattr(leaf, "weight") else 0

    def _around_the_center(self, bent: Any) -> Any:
        """Acceleration of the centre of mass less that of O_B, for Φ̈, (3, 1), world frame [m/s²]."""
        if self._bodies is None:
            return ca.SX(3, 1)
        center, rates = self.center_of_mass, body_rates(self.attitude, self.attitude_rates)
        turning = body_rates(self.attitude, bent) + ca.jtimes(rates, self.attitude, self.attitude_rates)
        return self.rotation @ (ca.cross(turning, center) + ca.cross(rates, ca.cross(rates, center)))

    @property
    def next_state(self) -> Any:
        """x⁺ by a semi-implicit Euler step: rates first, then with them what they change, (nx, 1)."""
        h, change = self.of["plan"].time_step, self.rates_of_change
        velocity, attitude_rates = self.velocity + h * change[:3], self.attitude_rates + h * change[3:6]
        joint_rate = self.joint_rate + h * change[6]
        return ca.vertcat(
            self.position + h * velocity, self.attitude + h * attitude_rates, velocity, attitude_rates,
            self.joint + h * joint_rate, joint_rate, self.arm_angles + h * self.arm_rates,
        )  # fmt: skip

    @cached_property
    def opening_rate(self) -> Any:
        """Rate q̇ towards the goal [rad/s or m/s]."""
        return self.of["mechanism"].sense * self.joint_rate

    @cached_property
    def to_go(self) -> Any:
        """Way from q to the goal, positive before it [rad or m]."""
        return self.of["mechanism"].sense * (self.of["reference"].joint - self.joint)

    @cached_property
    def planes(self) -> dict[str, Any]:
        """By how much the rotor disc is nearer to face, jambs or walls than the margin, by their names [m]."""
        return planes(self, self._surroundings)

    def clear_of(self, normal: Any, distance: Any) -> Any:
        """How much nearer to a plane the rotor disc is than the margin; not positive where it is clear [m]."""
        extent = ca.sqrt(1 - ca.dot(normal, self.rotation[:, 2]) ** 2 + _LEAST_EXTENT)
        return self.of["vehicle"].radius * extent - distance + self.of["limits"].margin

    def symbolic_model(self, timed: bool = False) -> SymbolicModel:
        """No step leads through the poles of the Euler angles."""
        return SymbolicModel(
            self.state, self.inputs, self.next_state, parameters=self.parameters, integrator="discrete",
            node_parameters=self.time if timed else None, domain=ca.cos(self.attitude[1]),
        )  # fmt: skip

    @property
    def door_angle(self) -> Any:
        """Angle α, by its name in other door tasks [rad]."""
        return self.joint

    @property
    def door_rate(self) -> Any:
        """Rate α̇, by its name in other door tasks [rad/s]."""
        return self.joint_rate

    def names(self) -> list[str]:
        """Everything that an expression may use."""
        every = {*vars(self), *dir(type(self))} - {
            "names",
            "symbolic_model",
            "planes",
            "parameters",
            "state",
            "inputs",
        }
        return sorted(each for each in every if not each.startswith("_"))
