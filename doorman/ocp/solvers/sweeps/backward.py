r"""Backward pass of CDDP: value function and policy, node by node (Xie, Liu and Hauser 2017).

At node k the rows of state k + 1, of input k and their bounds are linearised, c + C_x δx + C_u δu ≤ 0. The quadratic program
in δu at δx = 0 gives the active rows; keeping these active gives policy and value by one KKT system. With the rows after the
elimination of the input, [C̃_x | c̃], with T and S of `stage_program` and S_aa = L_s L_sᵀ, [Z | z] = L_s⁻¹[C̃_x | c̃]_a:

.. math::
    V_{xx} = \bar V_{xx} + Z^T Z,\quad V_x = \bar V_x + Z^T z,\quad
    [K | k] = [\bar K | \bar k] - U^{-1} D^{-1} T_a^T L_s^{-T}[Z | z]

where the bar marks what `node_elimination` leaves without constraints.
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.flat_rows import store_multipliers
from doorman.ocp.solvers.sweeps.linear_algebra import cholesky, solve_lower, solve_upper
from doorman.ocp.solvers.sweeps.sized import eliminate
from doorman.ocp.solvers.sweeps.stage_program import ROW_TOLERANCE, export_program, gather_schur, solve_dual
from doorman.ocp.solvers.sweeps.sweep import set_base

DONE = -1
NOT_CONVEX = -2


@kernel
def fill_rows(work: Workspace, k: int) -> None:
    """Rows [C_x | c | C_u] of node k's program into `program.eliminated`."""
    nx, nu, wide = work.sizes.states, work.sizes.inputs, work.sizes.wide
    nh, nt, ng = work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    program, linear, nominal = work.program, work.linear, work.nominal
    rows, jacobian = program.eliminated, linear.jacobians[k]
    for i in range(nh + nt):
        slopes = linear.row_jacobians[k, i] if i < nh else linear.end_row_jacobians[i - nh]
        for j in range(wide):
            total = 0.0
            for m in range(nx):
                total += slopes[m] * jacobian[m, j]
            rows[i, j] = total
        rows[i, nx] = nominal.rows[k, i] if i < nh else nominal.end_rows[i - nh]
        if i >= nh and k < nominal.inputs.shape[0] - 1:
            rows[i, nx] = -1e300
    for i in range(ng):
        for j in range(wide):
            rows[nh + nt + i, j] = linear.input_row_jacobians[k, i, j]
        rows[nh + nt + i, nx] = nominal.input_rows[k, i]
    for i in range(program.bounded.shape[0]):
        index, side, row = program.bounded[i], program.side[i], nh + nt + ng + i
        if index < nx:
            for j in range(wide):
                rows[row, j] = side * jacobian[index, j]
            rows[row, nx] = side * (nominal.states[k + 1, index] - program.limit[i])
        else:
            for j in range(wide):
                rows[row, j] = 0.0
            rows[row, nx + 1 + index - nx] = side
            rows[row, nx] = side * (nominal.inputs[k, index - nx] - program.limit[i])
    for i in range(rows.shape[0]):
        program.constraints[i] = rows[i, nx]
        for a in range(nu):
            program.jacobian[i, a] = rows[i, nx + 1 + a]


@kernel
def eliminate_rows(work: Workspace) -> None:
    """Take the inputs out of the rows of the program, which leaves T and c̃."""
    nx, nu, wide = work.sizes.states, work.sizes.inputs, work.sizes.wide
    program, rows = work.program, work.program.eliminated
    for i in range(rows.shape[0]):
        for a in range(nu):
            share = rows[i, nx + 1 + a]
            program.projected[i, a] = share
            if share != 0.0:
                for j in range(wide):
                    rows[i, j] -= share * work.node.scaled[a, j]
        program.residuals[i] = rows[i, nx]


@kernel
def violated(work: Workspace, k: int) -> bool:
    """Whether the unconstrained step of node k violates a row of its program."""
    program, nx, nu = work.program, work.sizes.states, work.sizes.inputs
    for i in range(program.constraints.shape[0]):
        total = program.constraints[i]
        for a in range(nu):
            total += program.jacobian[i, a] * work.policy.gains[k, a, nx]
        if total > ROW_TOLERANCE:
            return True
    return False


@kernel
def keep_active(work: Workspace, k: int) -> bool:
    """Change value and policy of node k so that the rows `program.active[k]` stay active."""
    nx, nu, wide, narrow = work.sizes.states, work.sizes.inputs, work.sizes.wide, work.sizes.narrow
    program, value, gains, factors = work.program, work.node.value, work.policy.gains[k], work.policy.factors[k]
    dual, indices, factor = program.dual, program.indices, program.gathered
    count = gather_schur(program.projected, factors, program.active[k], indices, factor)
    if count > factor.shape[0] or not cholesky(factor, count, factor):
        return False
    for b in range(count):
        for j in range(wide):
            dual[b, j] = program.eliminated[indices[b], j]
    solve_lower(factor, count, wide, dual)
    for b in range(count):
        work.result.decrease -= 0.5 * dual[b, nx] ** 2
        for i in range(nx):
            scale = dual[b, i]
            for j in range(nx + 1):
                value[i, j] += scale * dual[b, j]
    solve_upper(factor, count, wide, dual)
    change = work.node.scaled  # this node's elimination is not needed any more
    for a in range(nu - 1, -1, -1):
        for j in range(narrow):
            total = 0.0
            for b in range(count):
                total -= program.projected[indices[b], a] * dual[b, j]
            total /= factors[a, a]
            for b in range(a + 1, nu):
                total -= factors[a, b] * change[b, j]
            change[a, j] = total
            gains[a, j] += total
    program.multipliers[:] = 0.0
    for b in range(count):
        program.multipliers[indices[b]] = dual[b, nx]
    return True


@kernel
def export_multipliers(work: Workspace, k: int) -> None:
    """Write the multipliers λ of node k's program to `work.multipliers`."""
    found = work.program.multipliers
    work.multipliers.states[k, :] = 0.0
    work.multipliers.inputs[k, :] = 0.0
    for i in range(found.shape[0]):
        found[i] = max(found[i], 0.0)
    store_multipliers(work, found, k, k)


@kernel
def backward(model: object, work: Workspace, start: int, regularization: float, settled: bool) -> int:
    """Backward pass from node `start` to 0."""
    nx, nu = work.sizes.states, work.sizes.inputs
    node, program, result = work.node, work.program, work.result
    for k in range(start, -1, -1):
        if not (settled and k == start):  # else value, factor and rows of this node are there from the last call
            work.active.input_count[k] = 0
            set_base(model, work, k, 1.0, regularization, True)
            if not eliminate(work.tiles, k, work):
                return NOT_CONVEX
            for a in range(nu):
                result.decrease += 0.5 * node.rows[a, nx] * node.scaled[a, nx]
            program.multipliers[:] = 0.0
            fill_rows(work, k)
            if not violated(work, k):
                for i in range(program.proposal.shape[0]):
                    program.active[k, i] = False
            else:
                eliminate_rows(work)
                for i in range(program.proposal.shape[0]):
                    program.proposal[i] = program.active[k, i]
                if work.settings.guess_active_sets == 0 or not solve_dual(work, k):
                    export_program(work, k, True)
                    return k
                for i in range(program.proposal.shape[0]):
                    program.active[k, i] = program.proposal[i]
                if not keep_active(work, k):
                    return NOT_CONVEX
        elif not keep_active(work, k):
            return NOT_CONVEX
        export_multipliers(work, k)
        for a in range(nu):
            change = work.weights.metric[a] * abs(work.policy.gains[k, a, nx])
            result.change = max(result.change, change)
    return DONE if abs(result.decrease) < np.inf else NOT_CONVEX
