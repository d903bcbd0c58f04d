r"""From Vicon's millimetres and angles to the body's pose in the world; the conversions stand nowhere else.

Tracker's rotations are Euler angles in the order x, y', z'' about turned axes: :math:`R_{VO} = R_x(a) R_y(b) R_z(c)` turns the
object's axes into Vicon's. With Vicon's axes in the world :math:`(p_V, R_{WV})` and the object in the body :math:`(p_O, R_{BO})`,

.. math::
    R = R_{WV}\, R_{VO}\, R_{BO}^T, \qquad P = p_V + R_{WV}\, p_{VO} - R\, p_O

World and body are this project's: z up, x forward, y left.
"""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from doorman.checks import vector
from doorman.kinematics.quaternions import Quaternion, Vector, conjugate, multiply, rotate
from doorman.kinematics.rotations import quaternion_of

MILLIMETRES = 1000
"""Of a metre."""


def object_quaternion(rotation: Vector) -> Quaternion:
    r"""Quaternion of Tracker's angles, :math:`q_x(a)\, q_y(b)\, q_z(c)`."""
    ca, sa, cb, sb, cc, sc = (f(0.5 * angle) for angle in rotation for f in (math.cos, math.sin))
    return (
        ca * cb * cc - sa * sb * sc,
        sa * cb * cc + ca * sb * sc,
        ca * sb * cc - sa * cb * sc,
        ca * cb * sc + sa * sb * cc,
    )


def object_angles(q: Quaternion) -> Vector:
    r"""Tracker's angles of a quaternion, the inverse of `object_quaternion`; at b = ±π/2 the angle c is 0."""
    w, x, y, z = q
    sine = 2.0 * (x * z + w * y)
    if abs(sine) > 1.0 - 1e-12:
        return (2.0 * math.atan2(x, w), math.copysign(0.5 * math.pi, sine), 0.0)
    return (
        math.atan2(2.0 * (w * x - y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(sine),
        math.atan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


class Alignment:
    """Where Vicon's axes stand in the world, and the tracked object in the body."""

    def __init__(
        self, origin_position: ArrayLike, origin_attitude: ArrayLike, object_position: ArrayLike, object_attitude: ArrayLike
    ) -> None:  # fmt: skip
        self._origin = vector(origin_position, 3, "mocap.origin_position").tolist()
        self._world = quaternion_of(vector(origin_attitude, 3, "mocap.origin_attitude"))
        self._offset = vector(object_position, 3, "mocap.object_position").tolist()
        self._body = conjugate(quaternion_of(vector(object_attitude, 3, "mocap.object_attitude")))

    def body_pose(self, translation: Vector, rotation: Vector) -> tuple[Vector, Quaternion]:
        quaternion = multiply(multiply(self._world, object_quaternion(rotation)), self._body)
        placed = rotate(self._world, [value / MILLIMETRES for value in translation])
        lever = rotate(quaternion, self._offset)
        x, y, z = (a + b - c for a, b, c in zip(self._origin, placed, lever, strict=True))
        return (x, y, z), quaternion
