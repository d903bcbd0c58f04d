r"""Attitude as ZYX Euler angles: :math:`R = R_z(\psi) R_y(\theta) R_x(\phi)` maps body to world."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import vector
from doorman.exceptions import SingularityError

Array = NDArray[np.float64]

_SMALLEST_COSINE = 1e-6


def rotation_body_to_world(attitude: ArrayLike) -> Array:
    r"""Rotation matrix :math:`R = R_z(\psi) R_y(\theta) R_x(\phi)`.

    Args:
        attitude: Φ = [φ, θ, ψ], shape (3,) [rad].

    Returns:
        R, shape (3, 3).

    Raises:
        DimensionError: if the attitude is not three finite numbers.
    """
    roll, pitch, yaw = vector(attitude, 3, "attitude")
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def attitude_from_rotation(rotation: ArrayLike) -> Array:
    """Euler angles Φ of a rotation matrix, with θ in (−π/2, π/2).

    Args:
        rotation: R, body to world, shape (3, 3).

    Returns:
        Φ = [φ, θ, ψ], shape (3,) [rad].

    Raises:
        SingularityError: if θ = ±π/2, where φ and ψ are not defined.
    """
    matrix = np.asarray(rotation, dtype=np.float64)
    if math.hypot(matrix[0, 0], matrix[1, 0]) < _SMALLEST_COSINE:
        raise SingularityError("Euler angles are singular", field="pitch", given=90.0, allowed="|pitch| < 90°")
    pitch = math.asin(max(-1.0, min(1.0, -matrix[2, 0])))
    return np.array([math.atan2(matrix[2, 1], matrix[2, 2]), pitch, math.atan2(matrix[1, 0], matrix[0, 0])])


def euler_rate_matrix(attitude: ArrayLike) -> Array:
    r"""Matrix W of :math:`\dot\Phi = W(\Phi)\,\Omega`.

    Args:
        attitude: Φ, shape (3,) [rad].

    Returns:
        W, shape (3, 3).

    Raises:
        SingularityError: if θ = ±π/2.
        DimensionError: if the attitude is not three finite numbers.
    """
    roll, pitch, _ = vector(attitude, 3, "attitude")
    cp = math.cos(pitch)
    if abs(cp) < _SMALLEST_COSINE:
        raise SingularityError(
            "Euler rates are singular", field="attitude[1]", given=float(pitch), allowed="|pitch| < π/2"
        )
    cr, sr, tp = math.cos(roll), math.sin(roll), math.tan(pitch)
    return np.array([[1.0, sr * tp, cr * tp], [0.0, cr, -sr], [0.0, sr / cp, cr / cp]])


def body_rate_matrix(attitude: ArrayLike) -> Array:
    r"""Inverse of W: :math:`\Omega = W^{-1}(\Phi)\,\dot\Phi`, regular everywhere.

    Args:
        attitude: Φ, shape (3,) [rad].

    Returns:
        W⁻¹, shape (3, 3).

    Raises:
        DimensionError: if the attitude is not three finite numbers.
    """
    roll, pitch, _ = vector(attitude, 3, "attitude")
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    return np.array([[1.0, 0.0, -sp], [0.0, cr, sr * cp], [0.0, -sr, cr * cp]])


def skew(v: ArrayLike) -> Array:
    """Matrix â of the cross product: â b = a × b.

    Args:
        v: Shape (3,).

    Returns:
        Shape (3, 3).
    """
    x, y, z = np.asarray(v, dtype=np.float64)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
