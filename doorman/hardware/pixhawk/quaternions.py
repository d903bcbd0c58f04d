"""Unit quaternions [w, x, y, z], which map the body to its world, and ZYX Euler angles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import vector
from doorman.exceptions import DimensionError

Array = NDArray[np.float64]


def wrap(angle: float) -> float:
    """The same angle in (−π, π].

    Args:
        angle: [rad].

    Returns:
        [rad].
    """
    return -(((-angle + math.pi) % (2.0 * math.pi)) - math.pi)


def multiply(first: ArrayLike, second: ArrayLike) -> Array:
    """Product of two quaternions: the rotation `second`, then `first`.

    Args:
        first: Shape (4,).
        second: Shape (4,).

    Returns:
        Shape (4,).
    """
    a, b, c, d = np.asarray(first, dtype=np.float64).tolist()
    e, f, g, h = np.asarray(second, dtype=np.float64).tolist()
    return np.array(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


def rotate(quaternion: ArrayLike, values: ArrayLike) -> Array:
    """A vector turned by a unit quaternion, v + 2 u × (u × v + w v).

    Args:
        quaternion: [w, u], shape (4,).
        values: Shape (3,).

    Returns:
        Shape (3,).
    """
    w, a, b, c = np.asarray(quaternion, dtype=np.float64).tolist()
    x, y, z = np.asarray(values, dtype=np.float64).tolist()
    p, q, r = b * z - c * y + w * x, c * x - a * z + w * y, a * y - b * x + w * z
    return np.array([x + 2.0 * (b * r - c * q), y + 2.0 * (c * p - a * r), z + 2.0 * (a * q - b * p)])


def quaternion_from_euler(attitude: ArrayLike) -> Array:
    """Unit quaternion of ZYX Euler angles, with w ≥ 0.

    Args:
        attitude: [φ, θ, ψ], shape (3,) [rad].

    Returns:
        Shape (4,).
    """
    roll, pitch, yaw = (0.5 * float(angle) for angle in np.asarray(attitude, dtype=np.float64))
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    values = [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
    return np.array(values) if values[0] >= 0.0 else -np.array(values)


def euler_from_quaternion(quaternion: ArrayLike) -> Array:
    """ZYX Euler angles of a unit quaternion; at θ = ±π/2, where only φ ∓ ψ is defined, φ is 0.

    Args:
        quaternion: Shape (4,).

    Returns:
        [φ, θ, ψ], shape (3,) [rad].
    """
    w, x, y, z = np.asarray(quaternion, dtype=np.float64).tolist()
    sine = max(-1.0, min(1.0, 2.0 * (w * y - x * z)))
    if abs(sine) > 1.0 - 1e-9:
        return np.array([0.0, math.copysign(math.pi / 2.0, sine), wrap(math.copysign(2.0, -sine) * math.atan2(x, w))])
    return np.array(
        [
            math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
            math.asin(sine),
            math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        ]
    )


def unit_quaternion(values: ArrayLike, field_name: str, tolerance: float = 1e-2) -> Array:
    """A checked quaternion, normalised: autopilots drop others without a word.

    Args:
        values: Shape (4,).
        field_name: Name of the argument, for the error.
        tolerance: By which the norm may differ from 1.

    Returns:
        Shape (4,), of norm 1.

    Raises:
        DimensionError: if it is not four finite numbers of norm 1.
    """
    quaternion = vector(values, 4, field_name)
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1.0) > tolerance:
        raise DimensionError("not a unit quaternion", field=field_name, given=norm, allowed="a norm of 1")
    return quaternion / norm
