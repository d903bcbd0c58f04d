"""The emulated autopilot's own position controller, and what it can be asked to do."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from doorman.arrays import Array
from doorman.gravity import weight_of
from doorman.hardware.quaternions import from_attitude, multiply
from doorman.rig.emulators.autopilot.vehicle.estimator import Estimate
from doorman.rig.emulators.autopilot.vehicle.plant import LEVEL, NOTHING

_POSITION_GAIN, _VELOCITY_GAIN = 2.2, 3.2
_MAX_SPEED, _LANDING_SPEED = np.array([1.5, 1.5, 1.0]), 0.6
_MAX_TILT = 0.6


class Task(Enum):
    IDLE = "motors idle on the ground"
    ATTITUDE = "attitude and thrust"
    POSITION = "position"
    VELOCITY = "velocity"
    LAND = "descend until on the ground"


@dataclass(frozen=True)
class Demand:
    task: Task
    quaternion: Array = field(default_factory=lambda: LEVEL)
    thrust: float = 0.0  # share of the largest, 0 … 1
    side: tuple[float, float] = (0.0, 0.0)  # thrust along the body's x and y axis, as normalised, −1 … 1
    position: Array = field(default_factory=lambda: NOTHING)
    velocity: Array = field(default_factory=lambda: NOTHING)
    acceleration: Array = field(default_factory=lambda: NOTHING)
    yaw: float | None = None


class FlightController:
    def __init__(self, weight: float) -> None:
        self._weight = weight
        self._anchor: Array | None = None  # where a landing began, shape (3,) [m]

    def actuate(self, demand: Demand, estimate: Estimate, max_force: float) -> tuple[float, Array]:
        if demand.task is not Task.LAND:
            self._anchor = None
        if demand.task is Task.ATTITUDE:
            return demand.thrust * max_force, demand.quaternion
        acceleration = demand.acceleration + _VELOCITY_GAIN * (self._velocity(demand, estimate) - estimate.velocity)
        return self._force(acceleration, estimate.yaw if demand.yaw is None else demand.yaw)

    def _velocity(self, demand: Demand, estimate: Estimate) -> Array:
        if demand.task is Task.VELOCITY:
            return demand.velocity
        if demand.task is Task.LAND:
            self._anchor = estimate.position if self._anchor is None else self._anchor
            x, y, _ = np.clip(_POSITION_GAIN * (self._anchor - estimate.position), -1.0, 1.0)
            return np.array([x, y, -_LANDING_SPEED])
        wanted = demand.velocity + _POSITION_GAIN * (demand.position - estimate.position)
        return np.clip(wanted, -_MAX_SPEED, _MAX_SPEED)

    def _force(self, acceleration: Array, yaw: float) -> tuple[float, Array]:
        x, y, z = acceleration.tolist()
        fall = weight_of(1.0)
        vertical = max(0.3 * fall, fall + min(max(z, -5.0), 5.0))
        scale = min(1.0, vertical * math.tan(_MAX_TILT) / max(1e-9, math.hypot(x, y)))
        x, y = scale * x, scale * y
        length = math.sqrt(x * x + y * y + vertical * vertical)
        return self._weight * length / fall, tilted((x / length, y / length, vertical / length), yaw)


def tilted(axis: tuple[float, float, float], yaw: float) -> Array:
    """Attitude whose z axis points along a unit vector, with a heading: the least tilt, then the turn."""
    x, y, z = axis
    w = math.sqrt(0.5 * (1.0 + z))
    return np.array(multiply((w, -y / (2.0 * w), x / (2.0 * w), 0.0), from_attitude((0.0, 0.0, yaw))))
