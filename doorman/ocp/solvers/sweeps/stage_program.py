r"""One node's quadratic program, by its dual where the active set is easily found; ProxQP serves the rest.

With :math:`Q_{uu} = U^T D U` and T = D_c U⁻¹, :math:`\min_v \tfrac12 v^T Q_{uu} v + Q_u^T v` s.t. :math:`c + D_c v \le 0` has
the conditions

.. math:: r = \tilde c - S\lambda \le 0,\quad \lambda \ge 0,\quad \lambda^T r = 0,\quad S = T D^{-1} T^T

with :math:`\tilde c` the rows at the unconstrained step. A guess of the active set is tried, corrected as a whole
(primal-dual active set, Hintermüller, Ito and Kunisch 2003) and taken only when it satisfies these conditions exactly; strict
convexity makes that the solution.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.linear_algebra import cholesky

ROW_TOLERANCE = 1e-10
"""A row that is violated by no more than this counts as satisfied [the row's unit]."""

_ATTEMPTS = 10


@kernel
def project_row(factors: Array, row: Array, projected: Array) -> None:
    """Row of T = D_c U⁻¹ from a row of D_c."""
    nu = projected.shape[0]
    for a in range(nu):
        total = row[a]
        for b in range(a):
            total -= projected[b] * factors[b, a]
        projected[a] = total


@kernel
def gather_schur(
    projected: Array, factors: Array, active: NDArray[np.bool_], indices: NDArray[np.int64], out: Array
) -> int:
    """Numbers of the active rows, and their block of S, lightly regularised."""
    count, nu, most = 0, projected.shape[1], out.shape[0]
    for i in range(active.shape[0]):
        if active[i]:
            if count == most:
                return int(most) + 1
            indices[count] = i
            count += 1
    for a in range(count):
        for b in range(a + 1):
            total = 0.0
            for j in range(nu):
                total += projected[indices[a], j] * projected[indices[b], j] / factors[j, j]
            out[a, b] = total
        out[a, a] = out[a, a] * (1.0 + 1e-12) + 1e-300
    return count


@kernel
def solve_dual(work: Workspace, k: int) -> bool:
    """Solve the conditions above for the rows in `program` with the factors of node k.

    Starts from and ends in `program.proposal`. On success `program.multipliers` holds λ, `gathered` the Cholesky factor of the
    active block of S, and `indices` its rows.
    """
    program, factors = work.program, work.policy.factors[k]
    active, values, projected, indices = program.proposal, program.residuals, program.projected, program.indices
    factor, dual, multipliers = program.gathered, program.dual, program.multipliers
    nu, n, most = projected.shape[1], values.shape[0], factor.shape[0]
    for _ in range(_ATTEMPTS):
        count = gather_schur(projected, factors, active, indices, factor)
        if count > most or not cholesky(factor, count, factor):
            return False
        for a in range(count):
            total = values[indices[a]]
            for b in range(a):
                total -= factor[a, b] * dual[b, 0]
            dual[a, 0] = total / factor[a, a]
        for a in range(count - 1, -1, -1):
            total = dual[a, 0]
            for b in range(a + 1, count):
                total -= factor[b, a] * dual[b, 0]
            dual[a, 0] = total / factor[a, a]
        for j in range(nu):
            total = 0.0
            for a in range(count):
                total += projected[indices[a], j] * dual[a, 0]
            program.step[j] = -total / factors[j, j]
        changed, contradiction, position = False, False, 0
        for i in range(n):
            if not values[i] > -1e200:
                continue
            residual = values[i]
            for j in range(nu):
                residual += projected[i, j] * program.step[j]
            if position < count and indices[position] == i:
                contradiction |= abs(residual) > 10.0 * ROW_TOLERANCE
                if dual[position, 0] < 0.0:
                    active[i] = False
                    changed = True
                position += 1
            elif residual > ROW_TOLERANCE:
                active[i] = True
                changed = True
        if not changed:
            if contradiction:  # among the active rows, hidden by the regularisation
                return False
            multipliers[:] = 0.0
            for a in range(count):
                multipliers[indices[a]] = dual[a, 0]
            return True
    return False


@kernel
def substitute_step(work: Workspace, k: int) -> None:
    """Replace `program.step` by U⁻¹ times it."""
    step, factors = work.program.step, work.policy.factors[k]
    nu = step.shape[0]
    for a in range(nu - 1, -1, -1):
        total = step[a]
        for b in range(a + 1, nu):
            total -= factors[a, b] * step[b]
        step[a] = total


@kernel
def export_program(work: Workspace, k: int, with_gradient: bool) -> None:
    """Hessian and gradient of node k's program, for a solver outside; its rows are in `program` already."""
    program, factors, nu, nx = work.program, work.policy.factors[k], work.sizes.inputs, work.sizes.states
    for i in range(nu):
        program.gradient[i] = 0.0
        for j in range(nu):
            total = 0.0
            for m in range(min(i, j) + 1):
                left = 1.0 if m == i else factors[m, i]
                right = 1.0 if m == j else factors[m, j]
                total += left * factors[m, m] * right
            program.hessian[i, j] = total
    if with_gradient:
        for i in range(nu):
            for m in range(i + 1):
                left = 1.0 if m == i else factors[m, i]
                program.gradient[i] += left * work.node.rows[m, nx]
