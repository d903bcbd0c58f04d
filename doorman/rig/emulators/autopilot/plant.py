"""What the emulated autopilot flies: an interface, and a simple vehicle behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81


@dataclass(frozen=True)
class PlantTruth:
    """What the vehicle really does."""

    position: Array
    """Shape (3,), world frame, z up [m]."""
    velocity: Array
    """Shape (3,), world frame [m/s]."""
    quaternion: Array
    """[w, x, y, z], body (x forward, y left, z up) to world, shape (4,)."""
    body_rates: Array
    """Shape (3,), body frame [rad/s]."""
    on_ground: bool


class AutopilotPlant(Protocol):
    """A vehicle with its attitude loop; the emulated autopilot gives thrust and attitude, as its mixer would.

    All of it is called from the emulated autopilot's thread; who shares the plant with others must see to their taking turns.
    """

    @property
    def weight(self) -> float:
        """Weight [N]."""

    def command(self, thrust: float, quaternion: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        """Fly with a thrust along the body's z axis, and along x and y [N], towards an attitude [w, x, y, z], until the next."""

    def stop_motors(self) -> None:
        """Let the motors stand still, until the next command."""

    def advance(self, duration: float) -> None:
        """Let time pass [s]; does nothing if somebody else advances the plant."""

    def truth(self) -> PlantTruth:
        """The vehicle as it is now."""


class SimplePlant:
    """A point mass whose attitude follows its setpoint with lags, on flat ground.

    Args:
        mass: [kg].
        ground: Height of the ground [m].
        yaw: At the start [rad].
    """

    def __init__(self, mass: float = 3.0, ground: float = 0.0, yaw: float = 0.0) -> None:
        self.mass = mass
        self.ground = ground
        self.disturbance = np.zeros(3)
        """Force on the vehicle, world frame [N]."""
        self._position = np.array([0.0, 0.0, ground])
        self._velocity = np.zeros(3)
        self._quaternion = np.array([math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)])
        self._rates = np.zeros(3)
        self._force = 0.0
        self._wanted_force = 0.0
        self._wanted = self._quaternion.copy()
        self._running = False

    @property
    def weight(self) -> float:
        """Weight [N]."""
        return self.mass * GRAVITY

    def command(self, thrust: float, quaternion: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        """Fly with a thrust [N] towards an attitude; its rotors are upright, and make no force to the side."""
        self._wanted_force, self._wanted = max(0.0, thrust), quaternion / np.linalg.norm(quaternion)
        self._running = True

    def stop_motors(self) -> None:
        """Let the motors stand still."""
        self._wanted_force, self._running = 0.0, False

    def advance(self, duration: float) -> None:
        """Let time pass [s], in steps of at most 4 ms."""
        steps = max(1, math.ceil(duration / 0.004 - 1e-9))
        for _ in range(steps):
            self._step(duration / steps)

    def truth(self) -> PlantTruth:
        """The vehicle as it is now."""
        grounded = bool(self._position[2] <= self.ground + 1e-3)
        return PlantTruth(
            self._position.copy(), self._velocity.copy(), self._quaternion.copy(), self._rates.copy(), grounded
        )

    def _step(self, dt: float) -> None:
        self._force += (self._wanted_force - self._force) * min(1.0, dt / 0.03)
        grounded = self._position[2] <= self.ground + 1e-3
        if self._running and not (grounded and self._force < 0.9 * self.weight):
            error = quaternion_product(quaternion_inverse(self._quaternion), self._wanted)
            error = error if error[0] >= 0.0 else -error
            wanted_rates = np.clip(16.0 * error[1:], -4.0, 4.0)
            self._rates += (wanted_rates - self._rates) * min(1.0, dt / 0.04)
        else:
            self._rates = np.zeros(3)
        turn = np.concatenate([[1.0], 0.5 * dt * self._rates])
        self._quaternion = quaternion_product(self._quaternion, turn)
        self._quaternion /= np.linalg.norm(self._quaternion)
        force = self._force * thrust_axis(self._quaternion) + self.disturbance - 0.3 * self._velocity
        self._velocity = self._velocity + dt * (force / self.mass - np.array([0.0, 0.0, GRAVITY]))
        self._position = self._position + dt * self._velocity
        if self._position[2] <= self.ground:
            self._position[2] = self.ground
            self._velocity = np.array([0.0, 0.0, max(0.0, float(self._velocity[2]))])


def quaternion_product(first: Array, second: Array) -> Array:
    """Product of two quaternions [w, x, y, z]."""
    a, b, c, d = first.tolist()
    e, f, g, h = second.tolist()
    return np.array(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


def quaternion_inverse(quaternion: Array) -> Array:
    """Inverse of a unit quaternion."""
    return np.asarray(quaternion * np.array([1.0, -1.0, -1.0, -1.0]))


def thrust_axis(quaternion: Array) -> Array:
    """The body's z axis in the world."""
    w, x, y, z = quaternion.tolist()
    return np.array([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)])


def into_body(quaternion: Array, vector: Array) -> Array:
    """A vector of the world in the axes of a body with this attitude."""
    w, x, y, z = quaternion.tolist()
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return np.asarray(rotation.T @ vector)


def yaw_of(quaternion: Array) -> float:
    """Yaw of an attitude [rad]."""
    w, x, y, z = quaternion.tolist()
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
