"""What the vehicle knows at the leaf: its motion, the force it feels, leaf and hinge, whether it touches, and the wind.

Wind and contact cannot be told apart while the tip pushes steadily. So in contact the wind stays what it was in free flight, but
for what no contact can explain: a pull, or more along the face than friction carries. Three things say that there is no contact:
the force fades, the tip draws back, or it gains speed as no leaf would.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.control.contact_monitor import ContactMonitor
from doorman.control.door_filter import DoorFilter
from doorman.control.door_observer import DoorObserver
from doorman.control.state_converter import StateConverter
from doorman.control.vehicle_observer import VehicleObserver
from doorman.kinematics.rotations import euler_rate_matrix
from doorman.model import GRAVITY, Model
from doorman.signals import Measurement

Array = NDArray[np.float64]

_NEAR = 0.03
"""A tip that is farther from the leaf's place does not touch it [m]."""
_FAR_WIND, _NEAR_WIND, _CONTACT_WIND = 0.4, 2.0, 1.0
"""Times in which the wind follows what is felt: far from the leaf, near it, and in contact what no contact explains [s]."""
_LEAST = 0.2
"""Force of a tip that touches [N]."""
_CARRIED = 0.5
"""Share of the normal force that friction is believed to carry."""
_MOVES = 0.02
"""A door that is faster teaches its resistance [rad/s],"""
_LEARNT = 0.3
"""in this time [s]."""
_NUDGE, _MOST_NUDGE, _NUDGE_FADES = 0.6, 2.5, 0.5
"""Growth of the resistance that a plan is told of while a door sticks [N m/s], its bound [N m], and its end once it moves [s]."""
_NUDGED_WITHIN = 0.07
"""Nearer to the goal it grows in proportion [rad]."""
_STANDS_AT_GOAL = 0.015
"""Nearer than this it does not grow [rad]."""
_DRAWN_BACK, _FAR_BACK, _FADED = 0.02, 0.06, 0.4
"""A tip that draws back by more than the first, while it feels less than the last, a share of what the hinge resists with, does
not touch; nor does one that draws back by more than the second [rad],"""
_GHOST, _GHOST_RATE, _GHOST_TIME = 1.5, 0.06, 0.3
"""nor one that moves on, faster than this [rad/s] and for longer [s], as if the leaf opened by itself with more [N m],"""
_SETTLED = 0.5
"""once the touch is older [s]."""
_PAST = 0.007
"""A tip that is farther than it last was in contact has met the leaf again [rad]."""
_RESISTANCE = (0.05, 6.0)
"""Within which resistance is believed [N m]."""


@dataclass(frozen=True, eq=False)
class LeafEstimate:
    """What is known at one time."""

    position: Array
    velocity: Array
    attitude: Array
    """Φ now, the measured one carried on by its rates, shape (3,) [rad]."""
    attitude_rates: Array
    arm_angles: Array
    door_angle: float
    door_rate: float
    touching: bool
    normal_force: float
    """λ that plans begin with [N]."""
    friction_force: Array
    """Of the tip on the face, along and up, shape (2,) [N]."""
    wind: Array
    resistance: float
    """Of the hinge against opening [N m],"""
    friction_share: float
    """of which this share does not drive it back."""
    inertia: float


class LeafEstimator:
    """Estimates of one flight.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
    """

    def __init__(self, model: Model, converter: StateConverter) -> None:
        settings, control = model.scenario.estimation, model.scenario.control
        self._converter = converter
        self._mass, self._lever = model.vehicle.mass, model.coupling.distance_from_hinge
        self._goal, self._rest = float(model.goal_state[3]), float(model.door.rest_angle)
        self._vehicle = VehicleObserver(self._mass, settings.vehicle_observer_rate)
        self._monitor = ContactMonitor(settings.contact)
        self._door, self._leaf = DoorFilter(model, settings), model.door
        self._torque = DoorObserver(model, control.door_observer_rate, _RESISTANCE[1])
        self._wind, self._friction = np.zeros(3), np.zeros(2)
        self._deepest, self._ghost, self._touched_at = math.inf, 0.0, 0.0
        self._resists, self._moved, self._more = 0.3, False, 0.0
        self._yaw = 0.0

    def update(
        self, measured: Measurement, rotors: Array, time_step: float, seeks: bool, wanted: float
    ) -> LeafEstimate:
        """Take in one measurement.

        Args:
            measured: What the sensors say.
            rotors: Their force since the last call, shape (3,), world frame [N].
            time_step: Since the last call [s].
            seeks: Whether the tip is to touch the leaf.
            wanted: Opening rate that is asked for [rad/s].
        """
        weight = np.array([0.0, 0.0, self._mass * GRAVITY])
        self._vehicle.update(measured.position, measured.pose_time, measured.time, rotors - weight, time_step)
        velocity, felt = self._vehicle.velocity.copy(), self._vehicle.outer_force
        tip = self._converter.tip(measured, velocity)
        normal = self._leaf.normal(self._door.angle)
        push = float(normal @ rotors)
        touching = self._contact(tip, normal, push, measured.time, time_step, seeks)
        acting = push + float(normal @ self._wind)
        self._door.update(
            acting, touching, tip[0], measured.pose_time, measured.time, time_step, wind=self._wind
        )  # fmt: skip
        if touching:
            self._torque.update(self._door.angle, self._door.rate, acting, self._door.inertia, time_step)
        else:
            self._torque.pause()
            if seeks:
                self._door.passed(tip[0])
        resistance = self._resistance(touching, wanted, time_step)
        force = self._forces(normal, felt, acting, resistance, time_step) if touching else 0.0
        attitude, rates = self._attitude(measured)
        hinge = self._door.hinge()
        closer = max(hinge.stiffness * (self._rest - self._door.angle), 0.0)
        slides = hinge.friction + 0.05
        return LeafEstimate(
            self._vehicle.position.copy(), velocity, attitude, rates, np.array(measured.arm_angles), self._door.angle,
            self._door.rate, touching, force, self._friction.copy(), self._wind.copy(), resistance,
            slides / (slides + closer), self._door.inertia,
        )  # fmt: skip

    def _contact(
        self, tip: tuple[float, float], normal: Array, push: float, now: float, time_step: float, seeks: bool
    ) -> bool:
        """Whether the tip touches; the wind follows what is felt where it does not."""
        felt, monitor = self._vehicle.outer_force, self._monitor
        near = seeks and self._lever * (tip[0] - self._door.angle) < _NEAR
        if not seeks:
            monitor.declare(False)
        was = monitor.touching
        force = float(normal @ (self._wind - felt))
        if not was:
            self._wind = self._wind + min(time_step / (_NEAR_WIND if near else _FAR_WIND), 1.0) * (felt - self._wind)
            if not near:
                monitor.listen(force, time_step)
        touching = seeks and monitor.update(force if near or was else 0.0, time_step)
        if touching and not was:
            self._deepest, self._touched_at = tip[0], now
        if near and not touching and tip[0] < self._deepest - _PAST and math.isfinite(self._deepest):
            touching, self._touched_at = True, now
            monitor.declare(True)
            expected = max((self._resists + self._more) / self._lever, _LEAST)
            self._wind, force = self._wind + (expected - force) * normal, expected
        if touching and self._is_none(tip, push + float(normal @ felt), force, now, time_step):
            touching = False
            monitor.declare(False)
            self._wind = self._wind + 0.5 * (felt - self._wind)
        return touching

    def _is_none(self, tip: tuple[float, float], moves: float, force: float, now: float, time_step: float) -> bool:
        """Whether what the tip does contradicts a contact."""
        self._deepest = min(self._deepest, tip[0])
        gains = moves / self._mass / self._lever
        opens_itself = tip[1] < -_GHOST_RATE and self._lever * force - self._door.inertia * gains < -_GHOST
        self._ghost = self._ghost + time_step if opens_itself else max(0.0, self._ghost - time_step)
        faded = self._lever * force < _FADED * (self._resists + self._more)
        back = tip[1] > _MOVES and tip[0] - self._deepest > (_DRAWN_BACK if faded else _FAR_BACK)
        if now - self._touched_at <= _SETTLED or not (back or self._ghost > _GHOST_TIME):
            return False
        self._ghost = 0.0
        if back:
            self._door.meet(self._deepest)
        return True

    def _resistance(self, touching: bool, wanted: float, time_step: float) -> float:
        """Torque of the hinge against opening: learnt while the door moves, and more where it sticks [N m]."""
        opening, left = -self._door.rate, self._door.angle - self._goal
        if touching and opening > _MOVES:
            share = min(time_step / _LEARNT, 1.0) if self._moved else 1.0
            self._resists, self._moved = self._resists + share * (-self._torque.estimate - self._resists), True
        if touching and opening < min(0.3 * wanted, _MOVES) and left > _STANDS_AT_GOAL:
            grows = _NUDGE * min(left / _NUDGED_WITHIN, 1.0) * time_step
            self._more = min(self._more + grows, _MOST_NUDGE)
        else:
            self._more *= math.exp(-time_step / _NUDGE_FADES)
        return min(max(self._resists + self._more, _RESISTANCE[0]), _RESISTANCE[1])

    def _forces(self, normal: Array, felt: Array, acting: float, resistance: float, time_step: float) -> float:
        """λ of vehicle and leaf that move as one; the wind takes what no contact explains."""
        leaf, vehicle = self._door.inertia, self._mass * self._lever
        reaction = resistance if -self._door.rate > _MOVES else max(-self._torque.estimate, 0.0)
        force = max((leaf * acting + vehicle * reaction) / (leaf + vehicle * self._lever), _LEAST)
        along, tip_force = self._leaf.leaf_direction(self._door.angle), self._wind - felt
        pressed = float(normal @ tip_force)
        dragged = np.array([along @ tip_force, tip_force[2]])
        carried = _CARRIED * max(pressed, force)
        self._friction = dragged * min(1.0, carried / max(float(np.hypot(*dragged)), 1e-9))
        over = dragged - self._friction
        unexplained = over[0] * along + np.array([0.0, 0.0, over[1]]) + min(pressed - _LEAST, 0.0) * normal
        self._wind = self._wind - min(time_step / _CONTACT_WIND, 1.0) * unexplained
        return force

    def _attitude(self, measured: Measurement) -> tuple[Array, Array]:
        """Φ now, without jumps of ψ, and Φ̇."""
        rates = np.asarray(euler_rate_matrix(measured.attitude) @ measured.body_rates)
        attitude = measured.attitude + (measured.time - measured.pose_time) * rates
        attitude[2] += 2.0 * math.pi * round((self._yaw - attitude[2]) / (2.0 * math.pi))
        self._yaw = float(attitude[2])
        return attitude, rates
