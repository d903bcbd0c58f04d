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

Array = NDArray[np.float64]


class ConstraintParameters(NamedTuple):
    """Numbers of the constraints, SI units."""

    radius: float
    distance_from_hinge: float
    door_width: float
    arm: ArmParameters


@kernel
def collision_constraints(p: ConstraintParameters, x: Array, h: Array) -> None:
    """Values of the constraints at `x` (5 + n,) into `h` (n_points + 3,)."""
    arm_kinematics(p.arm, x[5:])
    n_points = p.arm.points.shape[0]
    for k in range(n_points):
        h[k] = p.arm.points[k, 2]
    dx, dy, dz = p.arm.points[n_points - 1, 0], p.arm.points[n_points - 1, 1], p.arm.points[n_points - 1, 2]
    sr, cr, sp, cp, sy, cy = np.sin(x[0]), np.cos(x[0]), np.sin(x[1]), np.cos(x[1]), np.sin(x[2]), np.cos(x[2])
    sd, cd = np.sin(x[3] - x[2]), np.cos(x[3] - x[2])
    nx, ny, nz = cp * sd, sp * sr * sd - cr * cd, sp * cr * sd + sr * cd
    across = sy * cp * dx + (sy * sp * sr + cy * cr) * dy + (sy * sp * cr - cy * sr) * dz
    contact = p.distance_from_hinge * np.sin(x[3])
    h[n_points] = p.radius * np.sqrt(nx * nx + ny * ny) - (nx * dx + ny * dy + nz * dz)
    h[n_points + 1] = contact - p.door_width + p.radius - across
    h[n_points + 2] = across - contact + p.radius


@kernel
def collision_constraints_jacobian(p: ConstraintParameters, x: Array, h: Array, jacobian: Array) -> None:
    """Values into `h` (n_points + 3,) and Jacobian into `jacobian` (n_points + 3, 5 + n)."""
    arm_kinematics(p.arm, x[5:])
    n_points = p.arm.points.shape[0]
    n_arm = p.arm.joints.shape[0]
    tip, door, lower, upper = n_points - 1, n_points, n_points + 1, n_points + 2
    dx, dy, dz = p.arm.points[tip, 0], p.arm.points[tip, 1], p.arm.points[tip, 2]
    sr, cr, sp, cp, sy, cy = np.sin(x[0]), np.cos(x[0]), np.sin(x[1]), np.cos(x[1]), np.sin(x[2]), np.cos(x[2])
    sd, cd = np.sin(x[3] - x[2]), np.cos(x[3] - x[2])
    nx, ny, nz = cp * sd, sp * sr * sd - cr * cd, sp * cr * sd + sr * cd
    yx, yy, yz = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr  # second row of R
    extent = np.sqrt(nx * nx + ny * ny)
    across = yx * dx + yy * dy + yz * dz
    contact = p.distance_from_hinge * np.sin(x[3])
    slope = p.distance_from_hinge * np.cos(x[3])
    for k in range(n_points):
        h[k] = p.arm.points[k, 2]
    h[door] = p.radius * extent - (nx * dx + ny * dy + nz * dz)
    h[lower] = contact - p.door_width + p.radius - across
    h[upper] = across - contact + p.radius

    jacobian[:, :] = 0.0
    shrink = p.radius / max(extent, 1e-9)  # disc parallel to the leaf: a kink; the slope stays bounded there
    jacobian[door, 0] = shrink * ny * nz - (nz * dy - ny * dz)
    ax, ay, az = -sp * sd, cp * sr * sd, cp * cr * sd
    jacobian[door, 1] = shrink * (nx * ax + ny * ay) - (ax * dx + ay * dy + az * dz)
    bx, by, bz = cp * cd, sp * sr * cd + cr * sd, sp * cr * cd - sr * sd
    turn = shrink * (nx * bx + ny * by) - (bx * dx + by * dy + bz * dz)
    jacobian[door, 2] = -turn
    jacobian[door, 3] = turn
    by_roll = yz * dy - yy * dz
    by_pitch = -sy * sp * dx + sy * cp * sr * dy + sy * cp * cr * dz
    by_yaw = cy * cp * dx + (cy * sp * sr - sy * cr) * dy + (cy * sp * cr + sy * sr) * dz
    jacobian[upper, 0], jacobian[upper, 1], jacobian[upper, 2], jacobian[upper, 3] = by_roll, by_pitch, by_yaw, -slope
    for j in range(n_arm):
        for k in range(n_points):
            gx, gy, gz = point_derivative(p.arm, k, j)
            jacobian[k, 5 + j] = gz
            if k == tip:
                jacobian[door, 5 + j] = -(nx * gx + ny * gy + nz * gz)
                jacobian[upper, 5 + j] = yx * gx + yy * gy + yz * gz
    for j in range(5 + n_arm):
        jacobian[lower, j] = -jacobian[upper, j]


@kernel
def collision_constraints_batch(p: ConstraintParameters, states: Array, h: Array) -> None:
    """Values at every row of `states` (m, 5 + n) into `h` (m, n_points + 3)."""
    for i in range(states.shape[0]):
        collision_constraints(p, states[i], h[i])
