r"""Rotors: where thrust and torque come from, and the mixer that shares a demand out among them.

Rotor i at :math:`(x_i, y_i)` with thrust :math:`f_i` and sense :math:`s_i` (+1 counter-clockwise seen from above) makes

.. math::
    [f_t,\ \tau_x,\ \tau_y,\ \tau_z]^T = B f, \qquad B_i = [1,\ y_i,\ -x_i,\ -s_i\kappa]^T

with κ the ratio of drag torque to thrust. The mixer is :math:`f = B^+ [f_t, \tau]` where that is possible. Where it is not,
it gives up yaw first, then moves the thrust as little as roll and pitch need, and scales these only when no thrust is left
that carries them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
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


class MixerParameters(NamedTuple):
    """Numbers of the mixer kernel."""

    inverse: Array
    """B⁺, shape (m, 4)."""
    allocation: Array
    """B, shape (4, m)."""
    max_thrusts: Array
    """Shape (m,) [N]."""
    thrusts: Array
    """Result: thrust set point of every rotor, shape (m,) [N]."""
    achieved: Array
    """Result: [f_t, τ] that these make, shape (4,)."""

    @classmethod
    def of(cls, layout: RotorLayout) -> MixerParameters:
        """Parameters of a layout."""
        m = layout.count
        inverse = np.ascontiguousarray(np.linalg.pinv(layout.allocation))
        return cls(inverse, layout.allocation.copy(), layout.max_thrusts.copy(), np.zeros(m), np.zeros(4))


@kernel
def tilt_scale(p: MixerParameters, roll_torque: float, pitch_torque: float) -> float:
    """Largest share of a roll and pitch torque that some thrust can carry with every rotor inside its limits."""
    scale = 1.0
    for i in range(p.thrusts.shape[0]):
        low = (p.inverse[i, 1] * roll_torque + p.inverse[i, 2] * pitch_torque) / p.inverse[i, 0]
        for j in range(p.thrusts.shape[0]):
            high = (p.inverse[j, 1] * roll_torque + p.inverse[j, 2] * pitch_torque) / p.inverse[j, 0]
            room = p.max_thrusts[j] / p.inverse[j, 0]
            if (high - low) * scale > room:
                scale = room / (high - low)
    return scale


@kernel
def mix(p: MixerParameters, thrust: float, torque: Array) -> None:
    """Share [f_t, τ] out among the rotors: fills `p.thrusts`, inside [0, max], and `p.achieved`."""
    count = p.thrusts.shape[0]
    scale = tilt_scale(p, torque[0], torque[1])
    lowest, highest = -1e300, 1e300
    for i in range(count):
        tilt = scale * (p.inverse[i, 1] * torque[0] + p.inverse[i, 2] * torque[1])
        p.thrusts[i] = tilt
        lowest = max(lowest, -tilt / p.inverse[i, 0])
        highest = min(highest, (p.max_thrusts[i] - tilt) / p.inverse[i, 0])
    lift = max(min(thrust, highest), lowest)
    share = 1.0
    for i in range(count):
        p.thrusts[i] += lift * p.inverse[i, 0]
        turn = p.inverse[i, 3] * torque[2]
        if turn > 1e-12:
            share = min(share, max(p.max_thrusts[i] - p.thrusts[i], 0.0) / turn)
        elif turn < -1e-12:
            share = min(share, max(p.thrusts[i], 0.0) / -turn)
    p.achieved[:] = 0.0
    for i in range(count):
        f = min(max(p.thrusts[i] + share * p.inverse[i, 3] * torque[2], 0.0), p.max_thrusts[i])
        p.thrusts[i] = f
        for k in range(4):
            p.achieved[k] += p.allocation[k, i] * f
