"""Random configurations on the kinematic constraint, and ways from them to the edge of what constraints allow."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.kinematics.coupling import Coupling

Constraints = Callable[[Array], Array]
"""h of states (m, 5 + n) as an array (m, rows); a state is allowed where all rows are ≤ 0."""

_BISECTIONS = 24


@dataclass(frozen=True)
class Region:
    """Where configurations x = [Φ, α, 0, H] are drawn: any yaw, bounded tilt, the arm within its joint limits."""

    coupling: Coupling
    door_angles: tuple[float, float]
    """Range of α [rad]."""
    max_tilt: float
    """Largest angle between the body's z axis and the vertical [rad]."""

    def draw(self, count: int, generator: np.random.Generator) -> Array:
        """Uniform random states."""
        vehicle = self.coupling.vehicle
        states = np.zeros((count, 5 + vehicle.n_arm))
        states[:, :2] = generator.uniform(-self.max_tilt, self.max_tilt, (count, 2))
        states[:, 2] = generator.uniform(-math.pi, math.pi, count)
        states[:, 3] = generator.uniform(min(self.door_angles), max(self.door_angles), count)
        lower, upper = self.joint_range()
        states[:, 5:] = generator.uniform(lower, upper, (count, vehicle.n_arm))
        return states[self.contains(states)]

    def joint_range(self) -> tuple[Array, Array]:
        """Joint limits, a joint without limits taken as a full turn: two arrays of shape (n,) [rad]."""
        vehicle = self.coupling.vehicle
        return np.clip(vehicle.lower_limits, -math.pi, None), np.clip(vehicle.upper_limits, None, math.pi)

    def contains(self, states: Array) -> NDArray[np.bool_]:
        """Whether states are in the region."""
        lower, upper = self.joint_range()
        upright = np.cos(states[:, 0]) * np.cos(states[:, 1]) >= math.cos(self.max_tilt)
        swing = (states[:, 3] >= min(self.door_angles)) & (states[:, 3] <= max(self.door_angles))
        joints = ((states[:, 5:] >= lower) & (states[:, 5:] <= upper)).all(axis=1)
        return np.asarray(upright & swing & joints)

    def allowed(self, states: Array, constraints: Constraints) -> NDArray[np.bool_]:
        """Whether states are in the region and allowed by constraints."""
        return np.asarray(self.contains(states) & (constraints(states).max(axis=1) <= 0.0))

    def to_boundary(self, inside: Array, outside: Array, constraints: Constraints) -> Array:
        """Last allowed states on the straight lines from allowed states to others, by bisection."""
        low, high = np.zeros((len(inside), 1)), np.ones((len(inside), 1))
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2
            good = self.allowed(inside + (outside - inside) * middle, constraints)[:, None]
            low, high = np.where(good, middle, low), np.where(good, high, middle)
        return inside + (outside - inside) * low

    def near(self, states: Array, spread: float, copies: int, generator: np.random.Generator) -> Array:
        """Random neighbours of states, clipped to the swing and the joint limits."""
        around = np.tile(states, (copies, 1))
        around += generator.normal(0.0, spread, around.shape)
        around[:, 3] = np.clip(around[:, 3], min(self.door_angles), max(self.door_angles))
        around[:, 4] = 0.0
        around[:, 5:] = np.clip(around[:, 5:], *self.joint_range())
        return around
