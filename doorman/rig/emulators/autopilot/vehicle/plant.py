"""What the emulated autopilot flies: an interface, and a simple vehicle behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from doorman.arrays import Array
from doorman.gravity import weight_of
from doorman.hardware.quaternions import conjugate, multiply, rotate

FLIP = np.array([1.0, -1.0, -1.0])
"""NED or FRD of a world with z up or a body with z up, and back: half a turn about x."""
FLIP_QUATERNION = np.array([1.0, 1.0, -1.0, -1.0])
"""FRD to NED of body to world, and back."""
LEVEL, NOTHING = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
for _constant in (FLIP, FLIP_QUATERNION, LEVEL, NOTHING):
    _constant.flags.writeable = False


@dataclass(frozen=True)
class PlantTruth:
    position: Array  # shape (3,), world frame, z up [m]
    velocity: Array  # shape (3,), world frame [m/s]
    quaternion: Array  # [w, x, y, z], body (x forward, y left, z up) to world, shape (4,)
    body_rates: Array  # shape (3,), body frame [rad/s]
    on_ground: bool


class AutopilotPlant(Protocol):
    """A vehicle with its attitude loop; the emulated autopilot gives thrust and attitude, as its mixer would."""

    # The emulated autopilot's thread calls all of it; who shares the plant with others must see to their taking turns.

    @property
    def weight(self) -> float:
        """Weight [N]."""

    def command(self, thrust: float, quaternion: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        """Fly with a thrust, and a force to the side, towards an attitude, until the next command."""

    def stop_motors(self) -> None:
        """Let the motors stand still, until the next command."""

    def advance(self, duration: float) -> None:
        """Let time pass; does nothing if somebody else advances the plant."""

    def truth(self) -> PlantTruth:
        """The vehicle as it is now."""


class SimplePlant:
    """A point mass whose attitude follows its setpoint with lags, on flat ground."""

    def __init__(self, mass: float = 3.0, ground: float = 0.0) -> None:
        self.mass, self.ground = mass, ground
        self._position, self._velocity = np.array([0.0, 0.0, ground]), NOTHING
        self._quaternion = self._wanted = LEVEL
        self._rates = NOTHING
        self._force = self._wanted_force = 0.0

    @property
    def weight(self) -> float:
        return weight_of(self.mass)

    def command(self, thrust: float, quaternion: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        self._wanted_force, self._wanted = max(0.0, thrust), quaternion / np.linalg.norm(quaternion)

    def stop_motors(self) -> None:
        self._wanted_force = 0.0

    def advance(self, duration: float) -> None:
        """Let time pass, in steps of at most 4 ms."""
        steps = max(1, math.ceil(duration / 0.004 - 1e-9))
        for _ in range(steps):
            self._step(duration / steps)

    def truth(self) -> PlantTruth:
        return PlantTruth(self._position, self._velocity, self._quaternion, self._rates, self._grounded)

    @property
    def _grounded(self) -> bool:
        return bool(self._position[2] <= self.ground + 1e-3)

    def _step(self, dt: float) -> None:
        self._force += (self._wanted_force - self._force) * min(1.0, dt / 0.03)
        if self._wanted_force > 0.0 and not (self._grounded and self._force < 0.9 * self.weight):
            w, *axis = multiply(conjugate(self._quaternion.tolist()), self._wanted.tolist())
            wanted_rates = np.clip(math.copysign(16.0, w) * np.array(axis), -4.0, 4.0)
            self._rates = self._rates + (wanted_rates - self._rates) * min(1.0, dt / 0.04)
        else:
            self._rates = NOTHING
        turned = np.array(multiply(self._quaternion.tolist(), [1.0, *(0.5 * dt * self._rates).tolist()]))
        self._quaternion = turned / np.linalg.norm(turned)
        force = self._force * thrust_axis(self._quaternion) - 0.3 * self._velocity
        self._velocity = self._velocity + dt * (force / self.mass - np.array([0.0, 0.0, weight_of(1.0)]))
        self._position = self._position + dt * self._velocity
        if self._position[2] <= self.ground:
            self._position[2] = self.ground
            self._velocity = np.array([0.0, 0.0, max(0.0, float(self._velocity[2]))])


def thrust_axis(quaternion: Array) -> Array:
    """The body's z axis in the world."""
    return np.array(rotate(quaternion.tolist(), (0.0, 0.0, 1.0)))
