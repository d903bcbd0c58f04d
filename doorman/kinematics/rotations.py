r"""Attitude as ZYX Euler angles: :math:`R = R_z(\psi) R_y(\theta) R_x(\phi)` maps body to world."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import components, vector
from doorman.exceptions import SingularityError

SMALLEST_COSINE = 1e-6
"""Cosine of the pitch below which Euler angles count as singular."""


def rotation_body_to_world(attitude: ArrayLike) -> Array:
    r"""Rotation matrix :math:`R = R_z(\psi) R_y(\theta) R_x(\phi)`."""
    roll, pitch, yaw = components(attitude, 3, "attitude")
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        (
            cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
            sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
            -sp, cp * sr, cp * cr,
        )
    ).reshape(3, 3)  # fmt: skip


def quaternion_of(attitude: ArrayLike) -> tuple[float, float, float, float]:
    """Unit quaternion [w, x, y, z] of Euler angles, body to world."""
    roll, pitch, yaw = components(attitude, 3, "attitude")
    cr, sr, cp, sp = math.cos(0.5 * roll), math.sin(0.5 * roll), math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )


def attitude_from_rotation(rotation: ArrayLike) -> Array:
    """Euler angles Φ of a rotation matrix, with θ in (−π/2, π/2)."""
    matrix = np.asarray(rotation, dtype=np.float64)
    if math.hypot(matrix[0, 0], matrix[1, 0]) < SMALLEST_COSINE:
        raise SingularityError("Euler angles are singular", field="pitch", given=90.0, allowed="|pitch| < 90°")
    pitch = math.asin(max(-1.0, min(1.0, -matrix[2, 0])))
    return np.array([math.atan2(matrix[2, 1], matrix[2, 2]), pitch, math.atan2(matrix[1, 0], matrix[0, 0])])


def regular_state(state: ArrayLike, size: int, field: str, pitch: int = 1) -> Array:
    """A state with an attitude as a contiguous float array."""
    x = vector(state, size, field)
    if abs(x[pitch]) >= math.pi / 2 - SMALLEST_COSINE:
        raise SingularityError(
            "Euler rates are singular", field=f"{field}[{pitch}] (pitch)", given=float(x[pitch]),
            allowed="|pitch| < π/2",
        )  # fmt: skip
    return x


def regular_step(after: Array) -> Array:
    """State after a step, which begins with Φ, if the pitch stayed inside ±90°."""
    if np.isnan(after[1]):
        raise SingularityError(
            "the step leads through the singularity of the Euler rates", field="next state[1] (pitch)",
            allowed="|pitch| < π/2",
        )  # fmt: skip
    return after


def body_rates_of(attitudes: Array, rates: Array) -> Array:
    r"""Body rates :math:`\Omega = W^{-1}(\Phi)\,\dot\Phi` of many attitudes."""
    sr, cr, sp, cp = (f(angle) for angle in (attitudes[:, 0], attitudes[:, 1]) for f in (np.sin, np.cos))
    x, y, z = rates.T
    return np.column_stack([x - sp * z, cr * y + sr * cp * z, -sr * y + cr * cp * z])


def euler_rates(attitude: ArrayLike, body_rates: Array) -> tuple[float, float, float]:
    r"""Rates :math:`\dot\Phi = W(\Phi)\,\Omega` of one attitude: three numbers [rad/s]."""
    roll, pitch, _ = components(attitude, 3, "attitude")
    cr, sr, cp = math.cos(roll), math.sin(roll), math.cos(pitch)
    if abs(cp) < SMALLEST_COSINE:
        raise SingularityError("Euler rates are singular", field="attitude[1]", given=pitch, allowed="|pitch| < π/2")
    x, y, z = body_rates.tolist()
    turning = sr * y + cr * z
    return x + math.tan(pitch) * turning, cr * y - sr * z, turning / cp
