"""Unit quaternions (w, x, y, z), which turn the body's axes into the world's, as plain numbers.

For single rotations this is quicker than arrays.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import vector
from doorman.exceptions import DimensionError
from doorman.kinematics.rotations import SMALLEST_COSINE

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def wrap(angle: float) -> float:
    """Angle of the same direction in (−π, π]."""
    return -(((-angle + math.pi) % (2.0 * math.pi)) - math.pi)


def multiply(a: Iterable[float], b: Iterable[float]) -> Quaternion:
    """Product a b: first b, then a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(q: Iterable[float]) -> Quaternion:
    """Inverse rotation (w, −x, −y, −z)."""
    w, x, y, z = q
    return (w, -x, -y, -z)


def rotate(q: Iterable[float], v: Iterable[float]) -> Vector:
    r"""Rotated vector :math:`v + 2 w (u \times v) + 2\, u \times (u \times v)` with u = (x, y, z)."""
    w, x, y, z = q
    vx, vy, vz = v
    tx = 2.0 * (y * vz - z * vy)
    ty = 2.0 * (z * vx - x * vz)
    tz = 2.0 * (x * vy - y * vx)
    return (vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx)


def rotation_vector(q: Quaternion) -> Vector:
    """Axis times angle, with an angle of at most π [rad]."""
    w, x, y, z = q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-9 else 2.0
    return (scale * x, scale * y, scale * z)


def from_rotation_vector(v: Vector) -> Quaternion:
    """Rotation by an axis times an angle [rad]."""
    angle = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    scale = math.sin(0.5 * angle) / angle if angle > 1e-9 else 0.5
    return (math.cos(0.5 * angle), scale * v[0], scale * v[1], scale * v[2])


def angle_between(a: Iterable[float], b: Iterable[float]) -> float:
    """Angle that turns one into the other, 0 … π [rad]."""
    x, y, z = rotation_vector(multiply(conjugate(a), b))
    return math.sqrt(x * x + y * y + z * z)


def to_attitude(q: Iterable[float]) -> Vector:
    """ZYX Euler angles of a quaternion; at a pitch of ±π/2, where roll and yaw are not defined apart, the roll is 0."""
    w, x, y, z = q
    sine = 2.0 * (w * y - x * z)
    if 1.0 - sine * sine < SMALLEST_COSINE**2:
        return (0.0, math.copysign(0.5 * math.pi, sine), math.atan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (x * x + z * z)))
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(sine),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def to_rotation(values: ArrayLike) -> NDArray[np.float64]:
    q = vector(values, 4, "quaternion")
    q = (q / np.linalg.norm(q)).tolist()
    return np.column_stack([rotate(q, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))])


def from_rotation(rotation: NDArray[np.float64]) -> Quaternion:
    import pinocchio as pin  # not for the processes that relay poses: it takes a while to load

    x, y, z, w = pin.Quaternion(rotation).coeffs().tolist()
    return (w, x, y, z) if w >= 0.0 else (-w, -x, -y, -z)


def unit_quaternion(values: ArrayLike, field_name: str, tolerance: float = 1e-2) -> Quaternion:
    """A checked quaternion, normalised: autopilots drop others silently."""
    w, x, y, z = vector(values, 4, field_name).tolist()
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if abs(norm - 1.0) > tolerance:
        raise DimensionError("not a unit quaternion", field=field_name, given=norm, allowed="a norm of 1")
    return (w / norm, x / norm, y / norm, z / norm)
