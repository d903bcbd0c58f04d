"""The emulated autopilot's own position controller, and what it can be asked to do."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from doorman.rig.emulators.autopilot.estimator import Estimate
from doorman.rig.emulators.autopilot.plant import Array, quaternion_product, thrust_axis, yaw_of

_POSITION_GAIN = 2.2
_VELOCITY_GAIN = 3.2
_MAX_SPEED = np.array([1.5, 1.5, 1.0])
_MAX_TILT = 0.6


class Task(Enum):
    """What the vehicle is to do."""

    IDLE = "motors idle on the ground"
    ATTITUDE = "attitude and thrust"
    CLIMB_RATE = "attitude and climb rate"
    POSITION = "position"
    VELOCITY = "velocity"
    LAND = "descend until on the ground"


@dataclass(frozen=True)
class Demand:
    """A task with its targets, in the world frame."""

    task: Task
    quaternion: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    thrust: float = 0.0
    """Share of the largest, 0 … 1."""
    side: tuple[float, float] = (0.0, 0.0)
    """Thrust along the body's x and y axis, as normalised, −1 … 1."""
    climb_rate: float = 0.0
    position: Array = field(default_factory=lambda: np.zeros(3))
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    acceleration: Array = field(default_factory=lambda: np.zeros(3))
    yaw: float | None = None


class FlightController:
    """Turns a demand into thrust and attitude.

    Args:
        weight: Of the vehicle [N].
        gravity: [m/s²].
    """

    def __init__(self, weight: float, gravity: float) -> None:
        self._weight = weight
        self._gravity = gravity
        self._anchor: Array | None = None

    def actuate(self, demand: Demand, estimate: Estimate, max_force: float) -> tuple[float, Array]:
        """Thrust [N] and attitude for now; idle is no thrust."""
        level = self._level(yaw_of(estimate.quaternion))
        if demand.task not in (Task.LAND, Task.CLIMB_RATE):
            self._anchor = None
        if demand.task is Task.IDLE:
            return 0.0, level
        if demand.task is Task.ATTITUDE:
            return demand.thrust * max_force, demand.quaternion
        yaw = yaw_of(estimate.quaternion) if demand.yaw is None else demand.yaw
        if demand.task is Task.CLIMB_RATE:
            lift = self._lift(demand.climb_rate, estimate)
            return lift / max(0.3, float(thrust_axis(demand.quaternion)[2])), demand.quaternion
        if demand.task is Task.VELOCITY:
            wanted = demand.velocity
        elif demand.task is Task.LAND:
            if self._anchor is None:
                self._anchor = estimate.position.copy()
            wanted = np.clip(_POSITION_GAIN * (self._anchor - estimate.position), -1.0, 1.0)
            wanted[2] = -0.6
        else:
            wanted = demand.velocity + _POSITION_GAIN * (demand.position - estimate.position)
            wanted = np.clip(wanted, -_MAX_SPEED, _MAX_SPEED)
        acceleration = demand.acceleration + _VELOCITY_GAIN * (wanted - estimate.velocity)
        return self._force(acceleration, yaw)

    def _lift(self, climb_rate: float, estimate: Estimate) -> float:
        return self._weight * (1.0 + _VELOCITY_GAIN * (climb_rate - float(estimate.velocity[2])) / self._gravity)

    def _force(self, acceleration: Array, yaw: float) -> tuple[float, Array]:
        x, y, z = acceleration.tolist()
        vertical = max(0.3 * self._gravity, self._gravity + min(max(z, -5.0), 5.0))
        scale = min(1.0, vertical * math.tan(_MAX_TILT) / max(1e-9, math.hypot(x, y)))
        x, y = scale * x, scale * y
        length = math.sqrt(x * x + y * y + vertical * vertical)
        return self._weight * length / self._gravity, tilted((x / length, y / length, vertical / length), yaw)

    @staticmethod
    def _level(yaw: float) -> Array:
        return np.array([math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)])


def tilted(axis: tuple[float, float, float], yaw: float) -> Array:
    """Attitude whose z axis points along a unit vector, not straight down, with a heading: the least tilt, then the turn."""
    x, y, z = axis
    w = math.sqrt(0.5 * (1.0 + z))
    tilt = np.array([w, -y / (2.0 * w), x / (2.0 * w), 0.0])
    return quaternion_product(tilt, np.array([math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)]))
