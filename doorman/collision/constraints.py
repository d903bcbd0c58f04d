r"""Analytic collision constraints h(x) ≤ 0 with derivatives (the paper's hard constraints, misprint corrected).

Rows, for an arm of n joints (n + 2 rows for n ≥ 2):

1. :math:`S^3_z,\ \ldots,\ S^n_z,\ d_z \le 0`: the arm stays below the body.
2. :math:`R_A\sqrt{n_x^2+n_y^2} - n^T d \le 0` with :math:`n = R^T n_D`: the rotor disc is clear of the leaf's plane.
3. :math:`D_V\sin\alpha - D_w + R_A - (Rd)_y \le 0` and :math:`(Rd)_y - D_V\sin\alpha + R_A \le 0`: the disc is between the
   jambs. The paper prints + D_w in the lower bound; it follows from :math:`P_y - P_{hy} \le D_w - R_A` that it is −.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.kinematics.arm import ArmParameters, arm_kinematics, point_derivative
from doorman.numba_types.lanes import get, larger, put, sincos, square_root

Array = NDArray[np.float64]


class ConstraintParameters(NamedTuple):
    """Numbers of the constraints, SI units."""

    radius: float
    distance_from_hinge: float
    door_width: float
    arm: ArmParameters


@kernel
def collision_constraints(p: ConstraintParameters, x: Array, h: Array) -> None:
    """Values of the constraints at `x` (5 + n,) into `h` (n_points + 3,); both with an axis of lanes if the arm has one."""
    arm_kinematics(p.arm, x[5:])
    lanes, points, n_points = p.arm.lanes, p.arm.points, p.arm.points.shape[0]
    for k in range(n_points):
        put(h, k, get(points, (k, 2), lanes))
    tip = n_points - 1
    dx, dy, dz = get(points, (tip, 0), lanes), get(points, (tip, 1), lanes), get(points, (tip, 2), lanes)
    yaw, angle = get(x, 2, lanes), get(x, 3, lanes)
    sr, cr = sincos(get(x, 0, lanes))
    sp, cp = sincos(get(x, 1, lanes))
    sy, cy = sincos(yaw)
    sd, cd = sincos(angle - yaw)
    nx, ny, nz = cp * sd, sp * sr * sd - cr * cd, sp * cr * sd + sr * cd
    across = sy * cp * dx + (sy * sp * sr + cy * cr) * dy + (sy * sp * cr - cy * sr) * dz
    sa, _ = sincos(angle)
    contact = p.distance_from_hinge * sa
    put(h, n_points, p.radius * square_root(nx * nx + ny * ny) - (nx * dx + ny * dy + nz * dz))
    put(h, n_points + 1, contact - p.door_width + p.radius - across)
    put(h, n_points + 2, across - contact + p.radius)


@kernel
def collision_constraints_jacobian(p: ConstraintParameters, x: Array, h: Array, jacobian: Array) -> None:
    """Values into `h` (n_points + 3,) and Jacobian into `jacobian` (n_points + 3, 5 + n), an axis of lanes as above.

    Entries that are zero everywhere are not written: slopes of the arm's points but by its joints, of the others by α̇.
    """
    arm_kinematics(p.arm, x[5:])
    lanes, points, n_points = p.arm.lanes, p.arm.points, p.arm.points.shape[0]
    tip, door, lower, upper = n_points - 1, n_points, n_points + 1, n_points + 2
    dx, dy, dz = get(points, (tip, 0), lanes), get(points, (tip, 1), lanes), get(points, (tip, 2), lanes)
    yaw, angle = get(x, 2, lanes), get(x, 3, lanes)
    sr, cr = sincos(get(x, 0, lanes))
    sp, cp = sincos(get(x, 1, lanes))
    sy, cy = sincos(yaw)
    sd, cd = sincos(angle - yaw)
    sa, ca = sincos(angle)
    nx, ny, nz = cp * sd, sp * sr * sd - cr * cd, sp * cr * sd + sr * cd
    yx, yy, yz = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr  # second row of R
    extent = square_root(nx * nx + ny * ny)
    across = yx * dx + yy * dy + yz * dz
    contact = p.distance_from_hinge * sa
    for k in range(n_points):
        put(h, k, get(points, (k, 2), lanes))
    put(h, door, p.radius * extent - (nx * dx + ny * dy + nz * dz))
    put(h, lower, contact - p.door_width + p.radius - across)
    put(h, upper, across - contact + p.radius)

    shrink = p.radius / larger(extent, 1e-9)  # disc parallel to the leaf: a kink; the slope stays bounded there
    put(jacobian, (door, 0), shrink * ny * nz - (nz * dy - ny * dz))
    ax, ay, az = -sp * sd, cp * sr * sd, cp * cr * sd
    put(jacobian, (door, 1), shrink * (nx * ax + ny * ay) - (ax * dx + ay * dy + az * dz))
    bx, by, bz = cp * cd, sp * sr * cd + cr * sd, sp * cr * cd - sr * sd
    turn = shrink * (nx * bx + ny * by) - (bx * dx + by * dy + bz * dz)
    put(jacobian, (door, 2), -turn)
    put(jacobian, (door, 3), turn)
    by_roll = yz * dy - yy * dz
    by_pitch = -sy * sp * dx + sy * cp * sr * dy + sy * cp * cr * dz
    by_yaw = cy * cp * dx + (cy * sp * sr - sy * cr) * dy + (cy * sp * cr + sy * sr) * dz
    slope = p.distance_from_hinge * ca
    for row, sign in ((upper, 1.0), (lower, -1.0)):
        put(jacobian, (row, 0), sign * by_roll)
        put(jacobian, (row, 1), sign * by_pitch)
        put(jacobian, (row, 2), sign * by_yaw)
        put(jacobian, (row, 3), -sign * slope)
    for j in range(p.arm.joints.shape[0]):
        for k in range(n_points):
            gx, gy, gz = point_derivative(p.arm, k, j)
            put(jacobian, (k, 5 + j), gz)
            if k == tip:
                put(jacobian, (door, 5 + j), -(nx * gx + ny * gy + nz * gz))
                sideways = yx * gx + yy * gy + yz * gz
                put(jacobian, (upper, 5 + j), sideways)
                put(jacobian, (lower, 5 + j), -sideways)


@kernel
def collision_constraints_batch(p: ConstraintParameters, states: Array, h: Array) -> None:
    """Values at every row of `states` (m, 5 + n) into `h` (m, n_points + 3)."""
    for i in range(states.shape[0]):
        collision_constraints(p, states[i], h[i])
