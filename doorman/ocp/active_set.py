r"""A node's quadratic program by its dual, where the active set is easily found; ProxQP serves the rest.

With Q_uu = L Lᵀ and T = D L⁻ᵀ, :math:`\min_v \tfrac12 v^T Q_{uu} v + Q_u^T v` s.t. :math:`h + D v \le 0` has the conditions

.. math:: r = c - S\lambda \le 0,\quad \lambda \ge 0,\quad \lambda^T r = 0,\quad c = h - T y,\quad S = T T^T,\quad y = L^{-1}Q_u

A guess of the active set is tried, corrected as a whole (primal-dual active set, Hintermüller, Ito and Kunisch 2003) and
taken only when it satisfies these conditions exactly; strict convexity makes that the solution.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.ocp.linear_algebra import cholesky

Array = NDArray[np.float64]

ROW_TOLERANCE = 1e-10
"""A row that is violated by no more than this counts as satisfied [the row's unit]."""

_ATTEMPTS = 8


@kernel
def gather_schur(schur: Array, active: NDArray[np.bool_], indices: NDArray[np.int64], gathered: Array) -> int:
    """Collect the active rows' numbers in `indices` and their block of S, lightly regularised, in `gathered`."""
    count = 0
    for i in range(active.shape[0]):
        if active[i]:
            indices[count] = i
            count += 1
    for a in range(count):
        for b in range(a + 1):
            gathered[a, b] = schur[indices[a], indices[b]]
        gathered[a, a] *= 1.0 + 1e-12
    return count


@kernel
def solve_dual(
    schur: Array,
    values: Array,
    active: NDArray[np.bool_],
    indices: NDArray[np.int64],
    factor: Array,
    multipliers: Array,
) -> bool:
    """Solve the conditions above for c = `values`, starting from and ending in `active`; False if it does not settle.

    On success `factor` holds the Cholesky factor of the active block of S, `indices` its rows, `multipliers` λ.
    """
    n = values.shape[0]
    for _ in range(_ATTEMPTS):
        count = gather_schur(schur, active, indices, factor)
        if not cholesky(factor, count, factor):
            return False
        for a in range(count):
            total = values[indices[a]]
            for b in range(a):
                total -= factor[a, b] * multipliers[b]
            multipliers[a] = total / factor[a, a]
        for a in range(count - 1, -1, -1):
            total = multipliers[a]
            for b in range(a + 1, count):
                total -= factor[b, a] * multipliers[b]
            multipliers[a] = total / factor[a, a]
        changed, contradiction = False, False
        position = 0
        for i in range(n):
            residual = values[i]
            for a in range(count):
                residual -= schur[i, indices[a]] * multipliers[a]
            if position < count and indices[position] == i:
                contradiction |= abs(residual) > 10.0 * ROW_TOLERANCE
                if multipliers[position] < 0.0:
                    active[i] = False
                    changed = True
                position += 1
            elif residual > ROW_TOLERANCE:
                active[i] = True
                changed = True
        if not changed:
            if contradiction:  # among the active rows, hidden by the regularisation
                return False
            for i in range(n - 1, -1, -1):
                multipliers[i] = 0.0 if i >= count else multipliers[i]
            for a in range(count - 1, -1, -1):
                value = multipliers[a]
                multipliers[a] = 0.0
                multipliers[indices[a]] = value
            return True
    return False
