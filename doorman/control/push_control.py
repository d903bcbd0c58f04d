r"""Following a plan that pushes: force along the door's normal, position along the others.

.. math::
    F_n = \mathrm{clip}\big(F_n^{plan} + k_v (v_{plan} - v),\ F_{least},\ F_{most}\big) - n_D^T \hat F_{wind}

with the tip's speed v along the normal: the planned force as feed-forward, an impedance around the planned motion. A
position loop there would fight the door. What the plan accelerates the vehicle with about its tip is no part of it: a plan begins
where the push is, every one leans in with the same jerk, and what that feeds back would hold the push where it is.

The heading follows a reference with a memory, :math:`\dot\psi_r = \dot\psi_{plan} + \kappa(\psi - \psi_r)`: plans start from the
heading as it is, so that a steady torque of the tip would turn plan and vehicle away. Rotors' drag can do little against it.
But a tip that sticks to the leaf is a pivot, and a force along the leaf turns the vehicle about it, as far as friction carries
it and the jambs leave room,

.. math::
    F_t = F_t^{plan} + \frac{k_\psi}{r_n}(\psi - \psi_r), \qquad |F_t| \le s\,\mu\lambda_n

with the tip r_n ahead of the vehicle. The position is that of the reference, too.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doorman.control.doorway import Doorway
from doorman.control.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.model import Model
from doorman.planning.planner import Plan

Array = NDArray[np.float64]

_HEADING_RATE = 0.4
"""κ [1/s]."""
_ARM_TIME = 0.1
"""Time constant of the joint rates [s]: stiff servos make noise of angles a rattle of the tip, which then creeps on the leaf."""
_CREEP = 0.03
"""A slower door is not too fast wherever it is [rad/s]."""
_EARLY = math.radians(0.5)
"""By which a door that is braked should stop before the goal: wind may open it the more, the farther it is open [rad]."""
_LEAST_LEFT = math.radians(0.3)
"""Way that a braked door always has [rad]."""
_UNSURE = 0.5
"""Torque of a resistance that is not counted on where a door is braked [N m]."""
_LETTING_GO, _MOST_LESS = 8.0, 0.8
"""By which a tip that is too fast pushes less than the least [N s/m], and by how much at most [N]: gusts make the push unsure."""
_OVERSPEED = 1.15
"""Share of the largest rate beyond which the push brakes a door: a plan lets one that is faster be as fast as it is."""
_FAST = 1.3
"""Energy of a door that is too fast, as a multiple of what can surely be braked."""
_SLIP_TIME = 1.0
"""In which a slip of the tip is believed [s]: a tip that sticks elsewhere would wind up the position's observer."""
_LEAST_SAG = 0.04
"""A vertical slip is believed beyond this: it keeps a tip from creeping,"""
_MOST_SAG = 0.1
"""and up to this: to lift a tip that friction holds would take thrust that the push needs [m]."""
_NARROW = 0.03
"""Gap between disc and leaf from which on the push is eased [m],"""
_EASED = 150.0
"""by so much of it [N/m]."""
_STIFFNESS = 1.5
"""k_ψ [N m/rad]."""
_STICKS = 0.9
"""s, the share of the friction that a force along the leaf may take."""
_LEAST_AHEAD = 0.2
"""[m]."""
_HEADING_LEAD = 0.3
"""Largest difference of that reference from the heading [rad]."""


class PushController:
    """Setpoints along a plan whose tip pushes, and for a door that is held.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
    """

    def __init__(self, model: Model, converter: StateConverter) -> None:
        self._converter = converter
        self._settings, self._control = model.scenario.push, model.scenario.control
        self._lever = model.coupling.distance_from_hinge
        self._door, self._height = model.door, model.coupling.height
        self._doorway = Doorway(model)
        self._goal = float(model.goal_state[3])
        self._moving = model.door.inertia + model.vehicle.mass * self._lever**2
        self.push = 0.0
        """F_n that was asked for last, without the wind's share [N]."""
        self._heading: float | None = None
        self._arm_rates, self._slipped = np.zeros(model.n_arm), np.zeros(2)

    def begin(self, push: float) -> None:
        """Begin with a push of `push` [N], at whatever heading the vehicle has."""
        self.push, self._heading = push, None
        self._arm_rates, self._slipped = np.zeros_like(self._arm_rates), np.zeros(2)

    def follow(self, plan: Plan, time: float, estimate: Estimate, resistance: float, time_step: float) -> Setpoint:
        """Setpoint for a time of the plan.

        Args:
            plan: A usable plan.
            time: Since its first state [s].
            estimate: What is known now.
            resistance: Torque of the hinge against opening that the plan counts on [N m].
            time_step: Since the last call [s].

        Returns:
            The setpoint, with a push.
        """
        setpoint = self._converter.setpoint(plan, time, estimate.arm_angles)
        normal = self._door.normal(estimate.door_angle)
        self._arm_rates = self._arm_rates + min(time_step / _ARM_TIME, 1.0) * (setpoint.arm_rates - self._arm_rates)
        yaw = self._yaw(plan, time, setpoint.yaw, float(estimate.state[2]), time_step)
        place = setpoint.position + self._slip(estimate, time_step)
        place = self._turned(place, yaw - setpoint.yaw, estimate.door_angle)
        place = self._doorway.inside(place, setpoint.position, estimate.position, estimate.velocity)
        setpoint = replace(setpoint, position=place, yaw=yaw, arm_rates=self._arm_rates)
        planned = float(setpoint.normal @ setpoint.force)
        rate = self._converter.door_rate(plan, time + self._control.position_look_ahead)
        rate = max(rate, -_OVERSPEED * self._settings.max_rate)
        push = planned + self._settings.velocity_gain * (-self._lever * rate - estimate.tip_speed)
        least, most = self._bounds(max(0.0, resistance) / self._lever)
        if self._too_fast(estimate, resistance):
            least, most = self._braking(estimate, resistance, least)
        push = self._eased(min(max(push, least), most), estimate)
        beside = self._beside(self._converter.force_along_leaf(plan, time), push, estimate)
        return self._with(replace(setpoint, force=beside), normal, push, estimate)

    def _beside(self, planned: float, push: float, estimate: Estimate) -> Array:
        """Force along the leaf: the planned one, and what turns the vehicle to its heading, as far as the tip holds [N]."""
        leaf, pivot = self._door.leaf_direction(estimate.door_angle), self._pivot(estimate.door_angle)
        ahead = max(float(self._door.normal(estimate.door_angle) @ (pivot - estimate.position)), _LEAST_AHEAD)
        behind = 0.0 if self._heading is None else float(estimate.state[2]) - self._heading
        holds = _STICKS * self._settings.friction_coefficient * max(min(push, estimate.normal_force), 0.0)
        force = min(max(planned + _STIFFNESS * behind / ahead, -holds), holds)
        aside = force * float(leaf @ self._door.along)
        return force * self._doorway.room(aside, estimate.position, estimate.velocity) * leaf

    def _eased(self, push: float, estimate: Estimate) -> float:
        """A push that lets a vehicle which leans on the leaf with its disc nearly there straighten up again [N]."""
        gap = self._doorway.gap(estimate.position, estimate.state[:3], estimate.door_angle)
        return max(push - _EASED * max(_NARROW - gap, 0.0), min(push, self._settings.least_force))

    def _too_fast(self, estimate: Estimate, resistance: float) -> bool:
        """Whether the door is far from being stopped before the goal by the share of its resistance that plans count on."""
        return -estimate.door_rate > self._stoppable(estimate, resistance)

    def _stoppable(self, estimate: Estimate, resistance: float) -> float:
        """Rate that the share of the resistance that plans count on about stops before the goal [rad/s]."""
        left = max(estimate.door_angle - self._goal - _EARLY, 0.0)
        stopping = self._settings.stopping_share * max(resistance, 0.0) / self._moving * left
        return math.sqrt(2.0 * _FAST * stopping + _CREEP**2)

    def _braking(self, estimate: Estimate, resistance: float, least: float) -> tuple[float, float]:
        """Least and largest push on a door that is too fast [N].

        The largest leaves of the resistance what stops the door, even if wind takes some of it away: a strong closer must not
        win. The least lets go of a door that nevertheless stays too fast, as the push may be larger than it is believed to be.
        """
        settings, left = self._settings, max(estimate.door_angle - self._goal - _EARLY, _LEAST_LEFT)
        allowed = min(self._stoppable(estimate, resistance), _OVERSPEED * settings.max_rate)
        less = min(_LETTING_GO * max(estimate.tip_speed - self._lever * allowed, 0.0), _MOST_LESS)
        stops = (resistance - _UNSURE - self._moving * 0.5 * estimate.door_rate**2 / left) / self._lever
        return settings.least_force - less, max(stops, 0.5 * least, settings.least_force) - less

    def _yaw(self, plan: Plan, time: float, planned: float, heading: float, time_step: float) -> float:
        """Yaw to command, where the plan is at `planned` when the attitude loop gets there [rad]."""
        ahead = self._control.attitude_look_ahead
        turn = planned - self._converter.heading(plan, time)
        if self._heading is None:
            self._heading = heading
        self._heading += time_step * (turn / ahead + _HEADING_RATE * (heading - self._heading)) if ahead else 0.0
        self._heading = heading + min(max(self._heading - heading, -_HEADING_LEAD), _HEADING_LEAD)
        return self._heading + turn

    def _slip(self, estimate: Estimate, time_step: float) -> Array:
        """Where on the leaf the tip really is, beside the place that plans take: slowly believed, and not fought against."""
        along, up = self._converter.tip_offset(estimate.position, estimate.state)
        sag = min(max(up, -_MOST_SAG), _MOST_SAG)
        seen = np.array([along, sag - min(max(sag, -_LEAST_SAG), _LEAST_SAG)])
        self._slipped = self._slipped + min(time_step / _SLIP_TIME, 1.0) * (seen - self._slipped)
        slip: Array = self._slipped[0] * self._door.leaf_direction(estimate.door_angle)
        slip[2] += self._slipped[1]
        return slip

    def _turned(self, position: Array, angle: float, door_angle: float) -> Array:
        """Position that belongs to another heading, with the tip where it is: turned about it."""
        pivot = self._pivot(door_angle)
        cosine, sine = math.cos(angle), math.sin(angle)
        x, y = position[0] - pivot[0], position[1] - pivot[1]
        return np.array([pivot[0] + cosine * x - sine * y, pivot[1] + sine * x + cosine * y, position[2]])

    def _pivot(self, door_angle: float) -> Array:
        """Where the tip should be."""
        return self._door.contact_point(door_angle, self._lever, self._height)

    def hold(self, setpoint: Setpoint, push: float, estimate: Estimate) -> Setpoint:
        """The same position and heading, with a push of its own.

        Args:
            setpoint: Position and posture.
            push: F_n [N].
            estimate: What is known now.
        """
        self._heading = setpoint.yaw
        held = replace(setpoint, force=self._beside(0.0, push, estimate))
        return self._with(held, self._door.normal(estimate.door_angle), push, estimate)

    def _with(self, setpoint: Setpoint, normal: Array, push: float, estimate: Estimate) -> Setpoint:
        self.push = push
        beside = setpoint.force - float(normal @ setpoint.force) * normal
        force = push * normal + beside
        return replace(setpoint, normal=normal, push=push - float(normal @ estimate.wind), force=force)

    def _bounds(self, resistance: float) -> tuple[float, float]:
        """Least and largest push against a resistance at the tip, where the door is not too fast: it never throws it [N]."""
        least = max(self._settings.least_force, self._settings.least_share * resistance)
        return least, resistance + self._moving / self._lever * self._settings.max_acceleration
