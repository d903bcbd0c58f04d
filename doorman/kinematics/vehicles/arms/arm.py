r"""Kernel of the arm: joint and point positions from the constants of `ArmGeometry`, with Jacobians.

With :math:`R_i = R_{i-1}\,\mathrm{Rot}(a_i, \eta_i)`: joint i at :math:`p_i = p_{i-1} + R_{i-1} l_i`, its axis
:math:`R_{i-1} a_i`, a point of parent i at :math:`p_i + R_i o`. A joint that slides has :math:`R_i = R_{i-1}` and moves what
it carries by :math:`R_{i-1} a_i \eta_i`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.kinematics.vehicles.arms.arm_pattern import ArmGeometry
from doorman.numba_types.elementary import sincos


class ArmParameters(NamedTuple):
    """`ArmGeometry` for kernels, with the scratch memory that they write to."""

    axes: Array
    links: Array
    slides: NDArray[np.bool_]
    point_parents: NDArray[np.int64]
    point_offsets: Array
    positions: Array  # scratch: of every joint, shape (n, 3)
    directions: Array  # scratch: of its axis, shape (n, 3)
    points: Array  # scratch: positions of the points, shape (n_points, 3)

    @classmethod
    def of(cls, arm: ArmGeometry) -> ArmParameters:
        """Copy the constants (kernels take writable arrays only: read-only ones are another type) and add scratch."""
        n, n_points = len(arm.axes), len(arm.point_offsets)
        vectors = (arm.axes.copy(), arm.links.copy(), arm.slides.copy())
        constants = (*vectors, arm.point_parents.copy(), arm.point_offsets.copy())
        return cls(*constants, np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n_points, 3)))


@kernel
def arm_kinematics(arm: ArmParameters, angles: Array) -> None:
    """Fill `arm.positions`, `arm.directions` and `arm.points`, in the body frame."""
    n_points = arm.point_parents.shape[0]
    px, py, pz = 0.0, 0.0, 0.0
    r00, r01, r02 = 1.0, 0.0, 0.0
    r10, r11, r12 = 0.0, 1.0, 0.0
    r20, r21, r22 = 0.0, 0.0, 1.0
    for k in range(n_points):
        if arm.point_parents[k] < 0:
            for j in range(3):
                arm.points[k, j] = arm.point_offsets[k, j]
    for i in range(arm.axes.shape[0]):
        lx, ly, lz = arm.links[i, 0], arm.links[i, 1], arm.links[i, 2]
        px += r00 * lx + r01 * ly + r02 * lz
        py += r10 * lx + r11 * ly + r12 * lz
        pz += r20 * lx + r21 * ly + r22 * lz
        ax, ay, az = arm.axes[i, 0], arm.axes[i, 1], arm.axes[i, 2]
        arm.positions[i, 0] = px
        arm.positions[i, 1] = py
        arm.positions[i, 2] = pz
        arm.directions[i, 0] = r00 * ax + r01 * ay + r02 * az
        arm.directions[i, 1] = r10 * ax + r11 * ay + r12 * az
        arm.directions[i, 2] = r20 * ax + r21 * ay + r22 * az
        if arm.slides[i]:
            px += arm.directions[i, 0] * angles[i]
            py += arm.directions[i, 1] * angles[i]
            pz += arm.directions[i, 2] * angles[i]
        else:
            s, c = sincos(angles[i])
            v = 1.0 - c
            m00, m01, m02 = c + ax * ax * v, ax * ay * v - az * s, ax * az * v + ay * s
            m10, m11, m12 = ay * ax * v + az * s, c + ay * ay * v, ay * az * v - ax * s
            m20, m21, m22 = az * ax * v - ay * s, az * ay * v + ax * s, c + az * az * v
            r00, r01, r02 = (
                r00 * m00 + r01 * m10 + r02 * m20,
                r00 * m01 + r01 * m11 + r02 * m21,
                r00 * m02 + r01 * m12 + r02 * m22,
            )
            r10, r11, r12 = (
                r10 * m00 + r11 * m10 + r12 * m20,
                r10 * m01 + r11 * m11 + r12 * m21,
                r10 * m02 + r11 * m12 + r12 * m22,
            )
            r20, r21, r22 = (
                r20 * m00 + r21 * m10 + r22 * m20,
                r20 * m01 + r21 * m11 + r22 * m21,
                r20 * m02 + r21 * m12 + r22 * m22,
            )
        for k in range(n_points):
            if arm.point_parents[k] == i:
                ox, oy, oz = arm.point_offsets[k, 0], arm.point_offsets[k, 1], arm.point_offsets[k, 2]
                arm.points[k, 0] = px + r00 * ox + r01 * oy + r02 * oz
                arm.points[k, 1] = py + r10 * ox + r11 * oy + r12 * oz
                arm.points[k, 2] = pz + r20 * ox + r21 * oy + r22 * oz


@kernel
def point_derivative(arm: ArmParameters, point: int, joint: int) -> tuple[float, float, float]:
    """Derivative of a point's position by one joint's coordinate, after `arm_kinematics`."""
    points, positions, directions = arm.points, arm.positions, arm.directions
    if joint > arm.point_parents[point]:
        return 0.0, 0.0, 0.0
    if arm.slides[joint]:
        return directions[joint, 0], directions[joint, 1], directions[joint, 2]
    x = points[point, 0] - positions[joint, 0]
    y = points[point, 1] - positions[joint, 1]
    z = points[point, 2] - positions[joint, 2]
    ax, ay, az = directions[joint, 0], directions[joint, 1], directions[joint, 2]
    return ay * z - az * y, az * x - ax * z, ax * y - ay * x


@kernel
def tip_motion(
    arm: ArmParameters,
    attitude: Array,
    body_rates: Array,
    angles: Array,
    rates: Array,
    position: Array,
    velocity: Array,
) -> None:
    r"""Tip relative to O_B in world axes: :math:`R\,d` into `position`, :math:`R(\Omega\times d + J_d\dot H)` into `velocity`."""
    arm_kinematics(arm, angles)
    tip = arm.points.shape[0] - 1
    dx, dy, dz = arm.points[tip, 0], arm.points[tip, 1], arm.points[tip, 2]
    vx = body_rates[1] * dz - body_rates[2] * dy
    vy = body_rates[2] * dx - body_rates[0] * dz
    vz = body_rates[0] * dy - body_rates[1] * dx
    for j in range(arm.axes.shape[0]):
        gx, gy, gz = point_derivative(arm, tip, j)
        vx += gx * rates[j]
        vy += gy * rates[j]
        vz += gz * rates[j]
    sr, cr = sincos(attitude[0])
    sp, cp = sincos(attitude[1])
    sy, cy = sincos(attitude[2])
    xx, xy, xz = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    yx, yy, yz = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    position[0] = xx * dx + xy * dy + xz * dz
    position[1] = yx * dx + yy * dy + yz * dz
    position[2] = -sp * dx + cp * sr * dy + cp * cr * dz
    velocity[0] = xx * vx + xy * vy + xz * vz
    velocity[1] = yx * vx + yy * vy + yz * vz
    velocity[2] = -sp * vx + cp * sr * vy + cp * cr * vz
