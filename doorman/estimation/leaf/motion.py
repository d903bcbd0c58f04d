r"""Vehicle, tip and leaf in symbols, as an estimate sees them: attitude and arm are measured well enough to be inputs.

States :math:`[P, V, F_w, \omega_w, \xi, \ell, q, \dot q, \rho, \ln I, o, o_g, F_t]`: the mean wind on the vehicle (vertical
too), the rate at which it turns, and a gust as a share of it; the lift of the rotors beyond their command, as a share of that;
the mechanism, what resists its opening, and its inertia; how far the face stands before where it is believed to be, and how far
before the face a gripper has closed; the tip's friction on the face. With the rotors' commanded force f, the face's normal n, the
lever J, the leaf's weight G and the sense s of opening, a tip that touches presses by λ:

.. math::
    m\,a = (1 + \ell) R f - m g e_3 + (1 + \xi) F_w + \lambda n - F_t,\qquad \dot F_w = \omega_w e_3 \times F_w,\qquad
    I\,\ddot q = J^T(F_t - \lambda n) - s\,\rho - G .

An arm with mass has its centre at c: :math:`\dot V = a - R(\dot\Omega\times c + \Omega\times(\Omega\times c))`.
Tip and face keep their distance :math:`g = n^T(p_t - p(q)) - o`. From :math:`\ddot g = 0`

.. math::
    \lambda = -\frac{n^T a_0 + b - n^TJ\,(J^TF_t - s\rho - G)/I}{1/m + (n^TJ)^2/I},

with the acceleration :math:`a_0` without contact, and with b what turning and moving on add. The limit of an infinite inertia is
a leaf that stands. These are the equations of `doorman.planning.whole_body.task` in the limit of a stiff contact.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from doorman.dynamics.tip_on_face import TipOnFace
from doorman.estimation.leaf.numbers import PLACES, STATES
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern


class LeafMotion(TipOnFace):
    """Named CasADi expressions, SI units, world frame."""

    noise: Any
    """Numbers of the process noise."""
    sensor: Any
    """Numbers of the sensors' noise."""
    switch: Any
    """Numbers of the switching among hypotheses."""
    start: Any
    """Deviations before the first touch: a vertical wind stays as doubtful as it was."""
    frame: Any
    """The normal into what a tip feels for that does not move."""

    def __init__(self, pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> None:
        super().__init__(pattern, point_names, numbers)
        symbol = ca.SX.sym
        own = {name: symbol(name, size) for name, size in STATES.items()}
        own |= {"joint": self.door_angle, "joint_rate": self.door_rate}
        self.position, self.velocity, self.mean_wind, self.wind_turn, self.gust = (
            own[name] for name in ("position", "velocity", "wind", "wind_turn", "gust")
        )
        self.lift, self.resistance, self.log_inertia = (own[name] for name in ("lift", "resistance", "log_inertia"))
        self.face_offset, self.reach, self.friction_force = own["face"], own["reach"], own["friction"]
        self.state = ca.vertcat(*own.values())
        self.rotors, self.body_rates, self.turning = (symbol(name, 3) for name in ("rotors", "body_rate", "turning"))
        self.inputs = ca.vertcat(
            self.rotors, self.attitude, self.body_rates, self.turning, self.arm_angles, self.arm_rates
        )

    def column(self, **parts: Any) -> Any:
        """A column like the state, of named parts; 0 where none is given."""
        return ca.vertcat(*(parts.get(name, ca.SX.zeros(size)) for name, size in STATES.items()))

    def replaced(self, column: Any, **parts: Any) -> Any:
        """A column like the state, with other parts."""
        return ca.vertcat(*(parts.get(name, column[PLACES[name]]) for name in STATES))

    @cached_property
    def outward(self) -> Any:
        """n, away from the face, (3, 1)."""
        return -self.contact_normal

    @cached_property
    def gap(self) -> Any:
        """Distance of tip and face, positive in free air [m]."""
        return -self.depth - self.face_offset

    @cached_property
    def gap_rate(self) -> Any:
        """Its rate [m/s]."""
        return -self.closing_speed

    @cached_property
    def inertia(self) -> Any:
        """I [kg m², or kg]."""
        return ca.exp(self.log_inertia)

    @cached_property
    def friction(self) -> Any:
        """F_t of the tip on the face, (3, 1) [N]."""
        return self.friction_force[0] * self.leaf_direction + self.friction_force[1] * self.leaf.up

    @cached_property
    def slip(self) -> Any:
        """Velocity of the tip on the face, along and up, (2, 1) [m/s]."""
        return ca.vertcat(ca.dot(self.leaf_direction, self.slip_velocity), ca.dot(self.leaf.up, self.slip_velocity))

    @cached_property
    def wind(self) -> Any:
        """Wind of the moment, (3, 1) [N]; a gust is horizontal."""
        return ca.vertcat((1 + self.gust) * self.mean_wind[:2], self.mean_wind[2])

    @cached_property
    def acceleration_without(self) -> Any:
        """Acceleration a₀ of the body frame without a normal force, (3, 1) [m/s²]."""
        rotors = self.rotation @ ((1 + self.lift) * self.rotors)
        acceleration = (rotors + self.wind - self.friction - ca.vertcat(0, 0, self.weight)) / self.vehicle.mass
        return acceleration - self.rotation @ self._turned(self.center_of_mass)

    def _turned(self, arm: Any) -> Any:
        """Acceleration of a point of the body relative to its frame, body axes, (3, 1) [m/s²]."""
        return ca.cross(self.turning, arm) + ca.cross(self.body_rates, ca.cross(self.body_rates, arm))

    @cached_property
    def rest_of_gap(self) -> Any:
        """What turning and moving on add to the second derivative of the gap, b [m/s²]."""
        moved = ca.jtimes(
            self.gap_rate, ca.vertcat(self.position, self.door_angle), ca.vertcat(self.velocity, self.door_rate)
        )
        return moved + ca.dot(self.outward, self.rotation @ self._turned(self.tip_in_body))

    @cached_property
    def _pulled(self) -> Any:
        """Torque on the mechanism beside the normal force's [N m, or N]."""
        own = self.reference.sense * self.resistance + self.leaf.weight_torque
        return ca.dot(self.lever_of_tip, self.friction) - own

    @cached_property
    def _across(self) -> Any:
        """Lever of the normal force on the mechanism [m, or 1]."""
        return ca.dot(self.outward, self.lever_of_tip)

    @cached_property
    def _mobility(self) -> Any:
        """Of tip and leaf against each other [1/kg]."""
        return 1 / self.vehicle.mass + self._across**2 / self.inertia

    @cached_property
    def meets(self) -> Any:
        """Speed at which tip and face come together, where that is no error of a touch [m/s]."""
        return ca.fmax(-self.gap_rate - 2 * self.contact.gap_rate, 0)

    @cached_property
    def blow_on_moving(self) -> Any:
        """Force with which tip and leaf, as they meet, share their momentum [N]: a heavy leaf does not take the tip's speed."""
        return self.meets / self.contact.lasts / self._mobility

    @cached_property
    def blow_on_standing(self) -> Any:
        """The same of a leaf that goes on resting [N]."""
        return self.vehicle.mass * self.meets / self.contact.lasts

    @cached_property
    def force_on_moving(self) -> Any:
        """λ on a leaf that moves with the tip [N]."""
        drive = (
            ca.dot(self.outward, self.acceleration_without)
            + self.rest_of_gap
            - self._across * self._pulled / self.inertia
        )
        return -drive / self._mobility

    @cached_property
    def force_on_standing(self) -> Any:
        """λ on what does not move [N]."""
        return -self.vehicle.mass * (ca.dot(self.outward, self.acceleration_without) + self.rest_of_gap)

    @cached_property
    def force_on_frame(self) -> Any:
        """λ on what stops a tip that feels for it, into that [N]."""
        moves = self.acceleration_without + self.rotation @ self._turned(self.tip_in_body)
        return self.vehicle.mass * ca.dot(self.frame.normal, moves)

    def dynamics(
        self, force: Any, joint_acceleration: Any, friction_lasts: Any, resistance: Any = 0, bears: Any = 0
    ) -> Any:
        """ẋ with a normal force; the tip's friction fades within `friction_lasts` [s], the resistance grows.

        A tip that grips a lever `bears` what holds it down.
        """
        return self.column(
            position=self.velocity,
            velocity=self.acceleration_without + force * self.outward / self.vehicle.mass,
            wind=ca.vertcat(
                -self.wind_turn * self.mean_wind[1],
                self.wind_turn * self.mean_wind[0],
                -self.mean_wind[2] * (self.noise.draught / self.start.draught) ** 2 / 2,
            ),
            gust=-self.gust / self.noise.gust_lasts,
            joint=self.door_rate,
            joint_rate=joint_acceleration,
            resistance=resistance,
            friction=(bears - self.friction_force) / friction_lasts,
        )

    def borne(self, force: Any) -> Any:
        """What a leaf that rests under a normal force resists with: all that it is pushed with [N m, or N]."""
        torque = ca.dot(self.lever_of_tip, self.friction - self.outward * force) - self.leaf.weight_torque
        return self.reference.sense * torque

    def stuck(self, force: Any) -> Any:
        """Growth of the resistance of a leaf that rests though it is pushed, or drawn back: it bears that, and more [N m/s]."""
        way = self.contact.way
        return way * ca.fmax(way * (self.borne(force) - self.resistance) + self.contact.more, 0) / self.contact.sticks

    def pushed(self, force: Any) -> Any:
        """Acceleration of the mechanism under a normal force [rad/s² or m/s²]."""
        return (self._pulled - ca.dot(self.lever_of_tip, self.outward) * force) / self.inertia
