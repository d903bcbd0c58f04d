"""Unit quaternions (w, x, y, z) as plain numbers: for single rotations this is quicker than arrays."""

from __future__ import annotations

import math

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_SINGULAR = 1.0 - 1e-12


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Product a b: first b, then a.

    Args:
        a: Left factor.
        b: Right factor.
    """
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """Inverse rotation."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    r"""Rotated vector :math:`v + 2 w (u \times v) + 2\, u \times (u \times v)` with u = (x, y, z).

    Args:
        q: Rotation.
        v: Vector.
    """
    w, x, y, z = q
    tx = 2.0 * (y * v[2] - z * v[1])
    ty = 2.0 * (z * v[0] - x * v[2])
    tz = 2.0 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


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


def angle_between(a: Quaternion, b: Quaternion) -> float:
    """Angle that turns one into the other, 0 … π [rad]."""
    x, y, z = rotation_vector(multiply(conjugate(a), b))
    return math.sqrt(x * x + y * y + z * z)


def from_attitude(attitude: Vector) -> Quaternion:
    r"""Quaternion of ZYX Euler angles, :math:`q_z(\psi)\, q_y(\theta)\, q_x(\phi)`.

    Args:
        attitude: Φ = (φ, θ, ψ) [rad].
    """
    cr, sr, cp, sp, cy, sy = (f(0.5 * angle) for angle in attitude for f in (math.cos, math.sin))
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def to_attitude(q: Quaternion) -> Vector:
    """ZYX Euler angles of a quaternion; at a pitch of ±π/2, where roll and yaw are not defined apart, the roll is 0.

    Args:
        q: Rotation of the body into the world.

    Returns:
        Φ = (φ, θ, ψ) [rad].
    """
    w, x, y, z = q
    sine = 2.0 * (w * y - x * z)
    if abs(sine) > _SINGULAR:
        return (0.0, math.copysign(0.5 * math.pi, sine), math.atan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (x * x + z * z)))
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(sine),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )
