"""Spaces: names and bounds of observations and actions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.model import Model

FASTEST = 10.0
"""Bound of speeds [m/s], which a fall over the height of the room stays below."""
FASTEST_TURN = 20.0
"""Bound of body rates [rad/s]: three turns a second."""
FASTEST_DOOR = 10.0
"""Bound of the door's rate [rad/s]."""
PAST_LIMIT = 0.5
"""By which arm angles may be beyond their limits, by noise, a blow, or the play of a servo [rad]."""


class Observations:
    """Entries of an observation: names, and bounds of shape (14 + 2 n,)."""

    def __init__(self, model: Model, room: float) -> None:
        vehicle = model.vehicle
        self.names = (
            "position_x [m]", "position_y [m]", "position_z [m]", "velocity_x [m/s]", "velocity_y [m/s]", "velocity_z [m/s]",
            "roll [rad]", "pitch [rad]", "yaw [rad]", "body_rate_x [rad/s]", "body_rate_y [rad/s]", "body_rate_z [rad/s]",
            *(f"{name} [rad]" for name in vehicle.joint_names), *(f"{name}_rate [rad/s]" for name in vehicle.joint_names),
            "door_angle_from_goal [rad]", "door_rate [rad/s]",
        )  # fmt: skip
        door = max(math.pi, 2.0 * abs(model.start_angle - model.goal_angle))
        lower, upper = _turns(vehicle.lower_limits), _turns(vehicle.upper_limits)
        rates = 2.0 * np.asarray(vehicle.rate_limits)
        symmetric = np.repeat([room, FASTEST, math.pi, FASTEST_TURN], 3)
        low = np.concatenate([-symmetric, lower - PAST_LIMIT, -rates, [-door, -FASTEST_DOOR]])
        high = np.concatenate([symmetric, upper + PAST_LIMIT, rates, [door, FASTEST_DOOR]])
        self.low: NDArray[np.float32] = low.astype(np.float32)
        self.high: NDArray[np.float32] = high.astype(np.float32)


def action_names(model: Model) -> tuple[str, ...]:
    """Entries of an action."""
    return ("thrust", "roll", "pitch", "yaw", *(f"{name}_rate" for name in model.vehicle.joint_names))


def _turns(limits: NDArray[np.float64]) -> NDArray[np.float64]:
    """Limits of joints; a joint without them is within a turn."""
    return np.clip(np.asarray(limits, dtype=np.float64), -2.0 * math.pi, 2.0 * math.pi)
