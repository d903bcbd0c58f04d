"""What vehicle and arm can do, as bounds of the optimal control problem."""

from __future__ import annotations

import math

import numpy as np

from doorman.model import Model
from doorman.ocp.problem import Bounds


def reduced_bounds(model: Model) -> Bounds:
    """Bounds of [Φ, α, α̇, H] and [f_t, Ω, Ḣ_d] from `[limits]` and the vehicle's URDF; none if they are switched off.

    Args:
        model: Model of the scenario.

    Returns:
        Joint angles and rates, thrust and body rates; the tilt is a constraint of its own, see `least_cosine`.
    """
    limits, vehicle = model.scenario.limits, model.vehicle
    if not limits.enabled:
        return Bounds()
    rates = np.asarray(vehicle.rate_limits if limits.joint_rates is None else np.full(model.n_arm, limits.joint_rates))
    body = np.asarray(limits.body_rates)
    none = np.full(5, np.inf)
    return Bounds(
        state_lower=np.concatenate([-none, vehicle.lower_limits]),
        state_upper=np.concatenate([none, vehicle.upper_limits]),
        input_lower=np.concatenate([[limits.min_thrust], -body, -rates]),
        input_upper=np.concatenate([[vehicle.max_thrust], body, rates]),
    )


def least_cosine(model: Model) -> float:
    """Least cosine of the tilt, the angle between the body's z axis and the world's; −1 where it is free."""
    limits = model.scenario.limits
    return math.cos(limits.tilt) if limits.enabled else -1.0
