"""Small matrices in CasADi symbols."""

from __future__ import annotations

from typing import Any

import casadi as ca


def inverse_of_symmetric(matrix: Any) -> Any:
    """Inverse of a symmetric matrix by its cofactors."""
    xx, xy, xz, yy, yz, zz = (matrix[i, j] for i in range(3) for j in range(i, 3))
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    d, e, f = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    return ca.vertcat(ca.horzcat(a, b, c), ca.horzcat(b, d, e), ca.horzcat(c, e, f)) / (xx * a + xy * b + xz * c)
