"""Layout of a vehicle's rotors: where they are, what each can make, and what they make together."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import BackendError
from doorman.kinematics.urdf import frozen
from doorman.kinematics.vehicle import Vehicle

Array = NDArray[np.float64]

RING_SIZE = 6
RING_RADIUS = 0.7
"""Radius of the ring assumed where the URDF names no rotors, as a share of R_A."""


@dataclass(frozen=True)
class RotorLayout:
    """Rotors of one vehicle."""

    positions: Array
    """In the body, shape (m, 3) [m]."""
    directions: Array
    """+1 counter-clockwise seen from above, −1 clockwise, shape (m,)."""
    max_thrusts: Array
    """Shape (m,) [N]."""
    torque_per_thrust: float
    """κ [m]."""

    @property
    def count(self) -> int:
        """Number of rotors, m."""
        return len(self.directions)

    @property
    def allocation(self) -> Array:
        """B, shape (4, m): rotor thrusts to [f_t, τ]."""
        x, y = self.positions[:, 0], self.positions[:, 1]
        return np.array([np.ones(self.count), y, -x, -self.directions * self.torque_per_thrust])

    @property
    def torque_authority(self) -> Array:
        """Largest torque about each body axis around half thrust, shape (3,) [N m]."""
        return np.asarray(np.abs(self.allocation[1:]) @ (0.5 * self.max_thrusts))


def rotor_layout(vehicle: Vehicle, torque_per_thrust: float) -> RotorLayout:
    """Rotors that the URDF names; else a ring of six at 0.7 R_A that shares `vehicle.max_thrust`.

    Args:
        vehicle: The vehicle.
        torque_per_thrust: κ [m].

    Returns:
        The layout; thrust limits scaled so that they add up to `vehicle.max_thrust`.

    Raises:
        BackendError: if the rotors cannot make thrust and all three torques.
    """
    if vehicle.rotors:
        positions = np.array([rotor.position for rotor in vehicle.rotors])
        directions = np.array([rotor.direction for rotor in vehicle.rotors])
        limits = np.array([rotor.max_thrust for rotor in vehicle.rotors])
        limits *= vehicle.max_thrust / limits.sum()
    else:
        angles = math.pi / 6 + np.arange(RING_SIZE) * 2 * math.pi / RING_SIZE
        ring = RING_RADIUS * vehicle.radius
        positions = np.column_stack([ring * np.cos(angles), ring * np.sin(angles), np.zeros(RING_SIZE)])
        directions = np.where(np.arange(RING_SIZE) % 2 == 0, 1.0, -1.0)
        limits = np.full(RING_SIZE, vehicle.max_thrust / RING_SIZE)
    layout = RotorLayout(frozen(positions), frozen(directions), frozen(limits), torque_per_thrust)
    inverse = np.linalg.pinv(layout.allocation)
    if np.linalg.matrix_rank(layout.allocation, tol=1e-9) < 4 or (inverse[:, 0] <= 1e-6).any():
        raise BackendError(
            "the rotors cannot make thrust and torque about all three axes",
            file=vehicle.urdf,
            field="joints rotor_…",
            given=f"{layout.count} rotors",
            allowed="at least four around O_B, turning in both senses",
        )
    return layout
