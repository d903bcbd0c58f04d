r"""How a vehicle makes a force: by tilting its thrust, or, where its rotors push to every side, with its body level.

The force of a fully actuated vehicle lies in a polytope. Rotors i with the columns of `RotorLayout.inverse` make it where

.. math:: 0 \le f_z\,l_i + s_i^T [f_x, f_y] \le f_{i,max},

without torque; a share of every rotor is kept for that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import BackendError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.rotor_layout import RotorLayout, rotor_layout
from doorman.kinematics.vehicles.vehicle import Vehicle

LEVEL = 0.05
"""Roll and pitch that a fully actuated vehicle may be commanded [rad]: what turns it beside its command is held against."""
_KEPT = 0.08
"""Share of a rotor's largest thrust that is kept at either end for torques."""
_BESIDE = 0.25
"""Share of the largest thrust that a force to the side may take before the height."""
_LIFTS = (0.8, 1.2)
"""Lift of a plan, as shares of the weight."""


class RotorRoom(NamedTuple):
    r"""Thrusts :math:`T = l\,f_z + S\,[f_x, f_y]^T` that make a force with a level body, and their limits; k that differ."""

    lifts: Array
    """l, shape (k,)."""
    sides: Array
    """S, shape (k, 2)."""
    least: Array
    """Shape (k,) [N]."""
    most: Array
    """Shape (k,) [N]."""

    @property
    def numbers(self) -> dict[str, Array]:
        """By the names that tasks know them by; S row by row."""
        return {f"actuation.{name}": np.ravel(value) for name, value in self._asdict().items()}


class Actuation:
    """What one kind of vehicle does to make a force: this one has thrust along the body's z axis alone, and tilts."""

    rotors: RotorRoom | None = None
    """What bounds the force of a vehicle whose body stays level; None of one that tilts."""
    push: float | None = None
    """Force to every side beside a hover, of a vehicle whose body stays level; None of one that tilts [N]."""

    def __init__(self, max_thrust: float) -> None:
        self.max_thrust = max_thrust
        self.lift: tuple[float, float] = (0.0, max_thrust)
        """Least and largest thrust along the body's z axis of a plan, beside the settings' [N]."""

    @property
    def fully(self) -> bool:
        """Whether the body stays level."""
        return self.push is not None

    def within_limits(self, force: Array, yaw: float, max_tilt: float) -> Array:
        """Nearest sensible force: height is kept first, then the horizontal part is cut."""
        return saturate(force, self.max_thrust, max_tilt)

    def attitude(self, force: Array, yaw: float) -> Array:
        """Attitude with which a force is made."""
        return attitude_of_force(force, yaw)

    def body_force(self, force: Array, attitude: Array) -> Array:
        """What the rotors are to make, shape (3,), body frame [N]."""
        return np.array([0.0, 0.0, math.sqrt(force.dot(force))])


class BodyForce(Actuation):
    """Force to every side with a level body, by rotors that are fully actuated; weights are m g [N]."""

    def __init__(self, layout: RotorLayout, weight: float) -> None:
        self._lift, self._side = layout.inverse[:, 0], layout.side_inverse
        self._least, self._most = _KEPT * layout.max_thrusts, (1.0 - _KEPT) * layout.max_thrusts
        self._lifts = float((self._least / self._lift).max()), float((self._most / self._lift).min())
        super().__init__(float(layout.max_thrusts.sum()))
        self.lift = (max(_LIFTS[0] * weight, self._lifts[0]), min(_LIFTS[1] * weight, self._lifts[1]))
        self.push = max(float((self._room(weight) / np.linalg.norm(self._side, axis=1)).min()), 0.0)
        shares = np.column_stack([self._lift, self._side, self._least, self._most])
        unlike = np.unique(shares.round(6) + 0.0, axis=0)  # those that are opposite each other make the same
        self.rotors = RotorRoom(unlike[:, 0], unlike[:, 1:3], unlike[:, 3], unlike[:, 4])

    def within_limits(self, force: Array, yaw: float, max_tilt: float) -> Array:
        """Force cut to the polytope of a level body. See `Actuation`."""
        lift = min(max(float(force[2]), self._lifts[0]), self._lifts[1])
        c, s = math.cos(yaw), math.sin(yaw)
        side = self._side @ np.array([c * force[0] + s * force[1], c * force[1] - s * force[0]])
        room = np.where(side > 0.0, self._most - lift * self._lift, lift * self._lift - self._least)
        moved = np.abs(side) > 1e-12
        share = min(1.0, float((room[moved] / np.abs(side[moved])).min(initial=1.0)))
        return np.array([max(share, 0.0) * force[0], max(share, 0.0) * force[1], lift])

    def attitude(self, force: Array, yaw: float) -> Array:
        """Level attitude. See `Actuation`."""
        return np.array([0.0, 0.0, yaw])

    def body_force(self, force: Array, attitude: Array) -> Array:
        """The force in body axes. See `Actuation`."""
        return np.asarray(rotation_body_to_world(attitude).T @ force)

    def _room(self, lift: float) -> Array:
        return np.minimum(self._most - lift * self._lift, lift * self._lift - self._least)


def actuation_of(vehicle: Vehicle, torque_per_thrust: float) -> Actuation:
    """What a vehicle's rotors can do."""
    try:
        layout = rotor_layout(vehicle, torque_per_thrust)
    except BackendError:
        return Actuation(vehicle.max_thrust)
    return BodyForce(layout, vehicle.weight) if layout.fully_actuated else Actuation(vehicle.max_thrust)


def saturate(force: Array, max_thrust: float, max_tilt: float) -> Array:
    """Nearest sensible force within thrust and tilt: height is kept first, then the horizontal part is cut.

    Of the horizontal part, `_BESIDE` of the largest thrust comes before the height, which costs a thirtieth of the lift: a
    vehicle that lacks lift is not to be blown away besides.
    """
    x, y, z = force.tolist()
    horizontal = math.hypot(x, y)
    beside = min(horizontal, _BESIDE * max_thrust)
    vertical = min(max(z, 0.1 * max_thrust), math.sqrt(max_thrust**2 - beside**2))
    largest = min(vertical * math.tan(max_tilt), math.sqrt(max(max_thrust**2 - vertical**2, 0.0)))
    scale = 1.0 if horizontal <= largest else largest / horizontal
    return np.array((scale * x, scale * y, vertical))


def attitude_of_force(force: Array, yaw: float) -> Array:
    """Attitude whose body z axis points along a force."""
    (x, y, z), c, s = force.tolist(), math.cos(yaw), math.sin(yaw)
    forward, left = c * x + s * y, -s * x + c * y
    return np.array((math.atan2(-left, math.hypot(forward, z)), math.atan2(forward, z), yaw))
