"""Layout of a vehicle's rotors: where they are, how they are tilted, what each can make, and what they make together."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from doorman.arrays import Array, frozen
from doorman.exceptions import BackendError
from doorman.kinematics.vehicles.vehicle import Vehicle

RING_SIZE = 6
RING_RADIUS = 0.7
"""Radius of the ring assumed where the URDF names no rotors, as a share of R_A."""
_LEAST_SIDE = 0.05
"""Force to every side, as a share of the weight, from which on a hovering vehicle is fully actuated: less opens no door."""
_MOST_ASIDE = 0.02
"""Force to the side of rotors that lift, as a share of their thrust, up to which they count as lifting along z."""


@dataclass(frozen=True)
class RotorLayout:
    """Rotors of one vehicle."""

    positions: Array
    """In the body, shape (m, 3) [m]."""
    directions: Array
    """+1 counter-clockwise seen from where the thrust points to, −1 clockwise, shape (m,)."""
    max_thrusts: Array
    """Shape (m,) [N]."""
    torque_per_thrust: float
    """κ [m]."""
    axes: Array | None = None
    """Unit vectors of the thrusts, in the body, shape (m, 3); None where all are z."""
    fully_actuated: bool = False
    """Whether thrusts make force to every side beside lift and torques."""

    @property
    def count(self) -> int:
        """Number of rotors, m."""
        return len(self.directions)

    @property
    def thrust_axes(self) -> Array:
        """Unit vectors of the thrusts, in the body, shape (m, 3)."""
        return np.tile([0.0, 0.0, 1.0], (self.count, 1)) if self.axes is None else self.axes

    @property
    def wrench(self) -> Array:
        r"""Rotor thrusts to body force and torque about O_B, shape (6, m).

        .. math:: W_i = [z_i,\ p_i \times z_i - s_i\kappa z_i]
        """
        axes = self.thrust_axes
        drag = self.directions[:, None] * self.torque_per_thrust * axes
        return np.concatenate([axes.T, (np.cross(self.positions, axes) - drag).T])

    @property
    def rank(self) -> int:
        """Rank of `wrench`: 6 where body force and torque are free, 4 of upright rotors."""
        lengths = np.array([1.0, 1.0, 1.0, *[1.0 / max(float(np.abs(self.positions).max()), 1e-9)] * 3])
        return int(np.linalg.matrix_rank(lengths[:, None] * self.wrench, tol=1e-6))

    @property
    def allocation(self) -> Array:
        """B, shape (4, m): rotor thrusts to [f_t, τ]."""
        return self.wrench[2:]

    @property
    def inverse(self) -> Array:
        """[f_t, τ] to rotor thrusts, shape (m, 4); of a fully actuated vehicle without a force to the side."""
        if not self.fully_actuated:
            return np.asarray(np.linalg.pinv(self.allocation), dtype=np.float64)
        return np.asarray(np.linalg.pinv(self.wrench)[:, 2:], dtype=np.float64)

    @property
    def side_inverse(self) -> Array:
        """Body force along x and y to rotor thrusts without lift and torque, shape (m, 2); zeros where that is not free."""
        side = np.linalg.pinv(self.wrench)[:, :2] if self.fully_actuated else np.zeros((self.count, 2))
        return np.asarray(side, dtype=np.float64)

    @property
    def torque_authority(self) -> Array:
        """Largest torque about each body axis around half thrust, shape (3,) [N m]."""
        return np.asarray(np.abs(self.allocation[1:]) @ (0.5 * self.max_thrusts))


def rotor_layout(vehicle: Vehicle, torque_per_thrust: float) -> RotorLayout:
    """Rotors that the URDF names; else a ring of six at 0.7 R_A that shares `vehicle.max_thrust`."""
    axes = None
    if vehicle.rotors:
        positions = np.array([rotor.position for rotor in vehicle.rotors])
        directions = np.array([rotor.direction for rotor in vehicle.rotors])
        axes = np.array([rotor.axis for rotor in vehicle.rotors])
        limits = np.array([rotor.max_thrust for rotor in vehicle.rotors])
        limits *= vehicle.max_thrust / float(limits @ axes[:, 2])
    else:
        angles = math.pi / 6 + np.arange(RING_SIZE) * 2 * math.pi / RING_SIZE
        ring = RING_RADIUS * vehicle.radius
        positions = np.column_stack([ring * np.cos(angles), ring * np.sin(angles), np.zeros(RING_SIZE)])
        directions = np.where(np.arange(RING_SIZE) % 2 == 0, 1.0, -1.0)
        limits = np.full(RING_SIZE, vehicle.max_thrust / RING_SIZE)
    frozen_axes = None if axes is None or not axes[:, :2].any() else frozen(axes)
    layout = RotorLayout(frozen(positions), frozen(directions), frozen(limits), torque_per_thrust, frozen_axes)
    if layout.rank == 6 and _side_room(layout, vehicle.weight) >= _LEAST_SIDE * vehicle.weight:
        layout = replace(layout, fully_actuated=True)
    _check_steering(layout, vehicle)
    return layout


def _side_room(layout: RotorLayout, weight: float) -> float:
    """Force to every side that is left beside a hover [N]."""
    full = replace(layout, fully_actuated=True)
    hover, side = full.inverse[:, 0] * weight, np.linalg.norm(full.side_inverse, axis=1)
    room = np.minimum(hover, layout.max_thrusts - hover)
    return float((room[side > 0.0] / side[side > 0.0]).min(initial=np.inf))


def _check_steering(layout: RotorLayout, vehicle: Vehicle) -> None:
    inverse = layout.inverse
    if np.linalg.matrix_rank(layout.allocation, tol=1e-9) < 4 or (inverse[:, 0] <= 1e-6).any():
        raise BackendError(
            "the rotors cannot make thrust and torque about all three axes",
            file=vehicle.urdf,
            field="joints rotor_…",
            given=f"{layout.count} rotors",
            allowed="at least four around O_B, turning in both senses",
        )
    aside = float(np.hypot(*(layout.wrench[:2] @ inverse[:, 0])))
    if aside > _MOST_ASIDE:
        raise BackendError(
            "the rotors lift beside the body's z axis", file=vehicle.urdf, field="joints rotor_…",
            given=f"{math.degrees(math.atan(aside)):.1f}°", allowed=f"up to {math.degrees(_MOST_ASIDE):.0f}°, or rotors "
            f"that push to every side with {_LEAST_SIDE:.0%} of the weight",
        )  # fmt: skip
