r"""Backward pass of CDDP: value function and policy, node by node (Xie, Liu and Hauser 2017).

At node k, with V the value at k+1 and the constraints of state k+1 linearised, h + C(A δx + B δu) ≤ 0, the quadratic program
in δu at δx = 0 gives the active rows; keeping these active gives policy and value by one KKT system. In the terms of
`riccati`, with T = C_a B L⁻ᵀ, S = T Tᵀ = L_s L_sᵀ and [Z | z] = L_s⁻¹([C_a A | h_a] − T[Y | y]):

.. math::
    V_{xx} = Q_{xx} - Y^T Y + Z^T Z,\quad V_x = Q_x - Y^T y + Z^T z,\quad
    [K | k] = -L^{-T}\big([Y | y] + T^T L_s^{-T}[Z | z]\big)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.ocp.active_set import ROW_TOLERANCE, gather_schur, solve_dual
from doorman.ocp.functions import linearize_constraints, linearize_step
from doorman.ocp.linear_algebra import cholesky, solve_lower, solve_upper
from doorman.ocp.riccati import eliminate, expand, substitute
from doorman.ocp.workspace import Workspace

Array = NDArray[np.float64]

DONE = -1
NOT_CONVEX = -2


@kernel
def linearize(model: object, work: Workspace) -> None:
    """Dynamics and constraints along the nominal trajectory, which satisfies the dynamics."""
    states, inputs, constraints = work.nominal.states, work.nominal.inputs, work.nominal.constraints
    for k in range(inputs.shape[0]):
        linearize_step(model, states[k], inputs[k], work.policy.jacobians[k])
        linearize_constraints(model, states[k + 1], constraints[k], work.policy.constraint_jacobians[k])


@kernel
def violates(work: Workspace, k: int) -> bool:
    """Whether the unconstrained step of node k violates a linearised row."""
    nx, nu, nh = len(work.sizes.states), len(work.sizes.inputs), len(work.sizes.constraints)
    jacobian, gains, slopes = work.policy.jacobians[k], work.policy.gains[k], work.policy.constraint_jacobians[k]
    residuals = work.scratch.residuals
    for i in range(nh):
        residuals[i] = work.nominal.constraints[k, i]
    for m in range(nx):
        change = 0.0
        for a in range(nu):
            change += jacobian[m, nx + a] * gains[a, nx + nu]
        for i in range(nh):
            residuals[i] += slopes[i, m] * change
    for i in range(nh):
        if residuals[i] > ROW_TOLERANCE:
            return True
    return False


@kernel
def condense(work: Workspace, k: int) -> None:
    """Rows of the constraints with the input eliminated, T and S of node k."""
    nx, nu, nh, width = (
        len(work.sizes.states),
        len(work.sizes.inputs),
        len(work.sizes.constraints),
        len(work.sizes.width),
    )
    scratch, jacobian, slopes = work.scratch, work.policy.jacobians[k], work.policy.constraint_jacobians[k]
    rows, projected, half = scratch.rows, scratch.projected, scratch.half
    for i in range(nh):
        for j in range(width):
            total = 0.0
            for m in range(nx):
                total += slopes[i, m] * jacobian[m, j]
            rows[i, j] = total
        rows[i, nx + nu] = work.nominal.constraints[k, i]
        for a in range(nu):
            work.qp.jacobian[i, a] = rows[i, nx + a]
        for a in range(nu):
            scale = rows[i, nx + a] / half[a, nx + a]
            projected[i, a] = scale
            for j in range(width):
                rows[i, j] -= scale * half[a, j]
        scratch.residuals[i] = rows[i, nx + nu]
    fill_schur(projected, scratch.schur)


@kernel
def fill_schur(projected: Array, schur: Array) -> None:
    """S = T Tᵀ."""
    for i in range(projected.shape[0]):
        for j in range(i + 1):
            total = 0.0
            for a in range(projected.shape[1]):
                total += projected[i, a] * projected[j, a]
            schur[i, j] = total
            schur[j, i] = total


@kernel
def export_qp(work: Workspace, k: int) -> None:
    """Node k's quadratic program into `work.qp`, for a solver outside; its Jacobian is there already."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    factor, half, qp = work.policy.factors[k], work.scratch.half, work.qp
    for i in range(nu):
        qp.gradient[i] = 0.0
        for j in range(nu):
            total = 0.0
            for m in range(min(i, j) + 1):
                total += factor[i, m] * factor[j, m]
            qp.hessian[i, j] = total
        for m in range(i + 1):
            qp.gradient[i] += factor[i, m] * half[m, nx + nu]
    for i in range(qp.constraints.shape[0]):
        qp.constraints[i] = work.nominal.constraints[k, i]


@kernel
def keep_active(work: Workspace, k: int) -> bool:
    """Change value and policy of node k so that the rows `policy.active[k]` stay active; False if they are dependent."""
    nx, nu, width = len(work.sizes.states), len(work.sizes.inputs), len(work.sizes.width)
    scratch, policy = work.scratch, work.policy
    dual, indices, value, half = scratch.dual, scratch.indices, scratch.value, scratch.half_constrained
    count = gather_schur(scratch.schur, policy.active[k], indices, scratch.schur_factor)
    if not cholesky(scratch.schur_factor, count, scratch.schur_factor):
        return False
    for b in range(count):
        for j in range(width):
            dual[b, j] = scratch.rows[indices[b], j]
    solve_lower(scratch.schur_factor, count, width, dual)
    for b in range(count):
        scratch.result[2] -= 0.5 * dual[b, nx + nu] ** 2
        for i in range(nx):
            scale = dual[b, i]
            for j in range(width):
                value[i, j] += scale * dual[b, j]
    solve_upper(scratch.schur_factor, count, width, dual)
    half[:, :] = scratch.half
    for b in range(count):
        policy.multipliers[k, indices[b]] = dual[b, nx + nu]
        for a in range(nu):
            scale = scratch.projected[indices[b], a]
            for j in range(width):
                half[a, j] += scale * dual[b, j]
    substitute(work, k, half)
    return True


@kernel
def settle_active(work: Workspace, k: int) -> bool:
    """Find the active rows of node k by a guess; False if the guess does not settle."""
    scratch, active = work.scratch, work.policy.active
    for i in range(active.shape[1]):
        scratch.proposal[i] = active[k, i]
    if not solve_dual(
        scratch.schur, scratch.residuals, scratch.proposal, scratch.indices, scratch.schur_factor, work.qp.multipliers
    ):
        return False
    for i in range(active.shape[1]):
        active[k, i] = scratch.proposal[i]
    return True


@kernel
def backward(work: Workspace, start: int, regularization: float, guess: bool, settled: bool) -> int:
    """Backward pass from node `start` to 0.

    Args:
        work: Workspace, linearised; its value function is that of node `start` + 1.
        start: Node to begin with.
        regularization: Relative addition to the input weights.
        guess: Try to find active sets here; otherwise every node with a violated row is left to the caller.
        settled: Node `start` was left to the caller, who has settled its active set.

    Returns:
        DONE, NOT_CONVEX, or the node whose quadratic program (`work.qp`) the caller must solve: it then sets
        `work.policy.active` of that node and calls again with `start` = node and `settled` = True.
    """
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    scratch, policy = work.scratch, work.policy
    for k in range(start, -1, -1):
        if not (settled and k == start):  # else value, factor and rows of this node are there from the last call
            expand(work, k, regularization)
            if not eliminate(work, k):
                return NOT_CONVEX
            for a in range(nu):
                scratch.result[2] += 0.5 * scratch.half[a, nx + nu] ** 2
            policy.multipliers[k, :] = 0.0
            substitute(work, k, scratch.half)
            if not violates(work, k):
                policy.active[k, :] = False
            else:
                condense(work, k)
                if not (guess and settle_active(work, k)):
                    export_qp(work, k)
                    return k
                if not keep_active(work, k):
                    return NOT_CONVEX
        elif not keep_active(work, k):
            return NOT_CONVEX
        for a in range(nu):
            change = work.weights.input[a] * abs(policy.gains[k, a, nx + nu])
            scratch.result[3] = max(scratch.result[3], change)
    return DONE
