"""What vehicle and arm can do, as bounds of the optimal control problem."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.vehicles.actuation import LEVEL
from doorman.model import Model
from doorman.ocp.problem.problem import Bounds


def bounds_of(model: Model, free: int, least: float, steers: ArrayLike, rates: Array) -> Bounds:
    """Bounds of [x_1 … x_free, H], of which H alone has some, and of [f_t, three inputs that steer, Ḣ_d, f_x, f_y].

    The least thrust, and the largest magnitudes of what steers and of the joints' rates are given. The force to the side is
    bounded by the rotors' rows.
    """
    vehicle, actuation, none = model.vehicle, model.actuation, np.full(free, np.inf)
    others = np.concatenate([steers, rates, np.full(2 if actuation.fully else 0, np.inf)])
    return Bounds(
        state_lower=np.concatenate([-none, vehicle.lower_limits]),
        state_upper=np.concatenate([none, vehicle.upper_limits]),
        input_lower=np.concatenate([[max(least, actuation.lift[0])], -others]),
        input_upper=np.concatenate([[min(vehicle.max_thrust, actuation.lift[1])], others]),
    )


def tied_bounds(model: Model, free: int, body_rates: bool) -> Bounds:
    """Bounds of a tied tip's problem, from `[limits]` and the vehicle's URDF; none if switched off.

    Body rates are inputs of the one, and constraints of the other.
    """
    limits, n = model.scenario.limits, model.n_arm
    if not limits.enabled:
        return Bounds()
    rates = np.asarray(model.vehicle.rate_limits if limits.joint_rates is None else np.full(n, limits.joint_rates))
    steers = limits.body_rates if body_rates else np.full(3, np.inf)
    return bounds_of(model, free, 0.0, steers, rates)


_ALONG_THE_WAY = 5
"""Angles of the way at which the least of the largest forces is looked for."""


def largest_push(model: Model, tilt: float, door_angle: float | None = None) -> float:
    r"""Force on the leaf along its normal, towards the goal, that a vehicle which stays where it is has left.

    The thrust is :math:`F n + m_A g e_3`. With the normal's parts :math:`n_h` and :math:`n_z`, level and upwards, and the
    largest tilt θ and thrust,

    .. math::
        F (n_h - n_z\tan\theta) \le m_A g\tan\theta,\qquad
        F^2 + 2 F n_z m_A g + (m_A g)^2 \le f_{\max}^2 .
    """
    if door_angle is None:
        way = np.linspace(model.travel.start, model.travel.goal, 1 if model.door.vertical else _ALONG_THE_WAY)
        return min(largest_push(model, tilt, float(angle)) for angle in way)
    weight, upwards = model.vehicle.weight, -model.travel.sense * float(model.door.normal(door_angle)[2])
    level, slope = math.sqrt(1.0 - upwards**2), math.tan(tilt)
    if model.actuation.push is not None:
        return model.actuation.push / max(level, 1e-3)
    by_tilt = weight * slope / (level - upwards * slope) if level > upwards * slope else math.inf
    left = (upwards * weight) ** 2 + model.vehicle.max_thrust**2 - weight**2
    by_thrust = max(math.sqrt(max(left, 0.0)) - upwards * weight, 0.0)
    return min(by_tilt, by_thrust, model.scenario.control.max_push)


def least_cosine(model: Model) -> float:
    """Least cosine of the tilt, the angle between the body's z axis and the world's; −1 where it is free.

    A fully actuated vehicle stays level.
    """
    limits = model.scenario.limits
    if model.actuation.fully:
        return math.cos(LEVEL)
    return math.cos(limits.tilt) if limits.enabled else -1.0
