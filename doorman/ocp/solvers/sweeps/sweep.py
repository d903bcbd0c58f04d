r"""Riccati sweep of the augmented Lagrangian, and the step that follows from it.

Each row h ≤ 0 has a multiplier λ ≥ 0 and a penalty 1/μ. The active rows add :math:`h_x^T h_x/\mu` to V_xx and
:math:`h_x^T(\lambda + h/\mu)` to V_x of their state. Rows g add likewise to the node's cost, and bounds to a diagonal.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.full_weights import expand_beyond_diagonals
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows
from doorman.ocp.solvers.sweeps.sized import add_square, eliminate, set_slopes, step_node


@kernel
def terminal_value(model: object, work: Workspace) -> None:
    """Value function of the last state; resets the predicted decrease."""
    nx = work.sizes.states
    last, weights, value = work.nominal.states[work.nominal.inputs.shape[0]], work.weights, work.node.value
    value[:, :] = 0.0
    for i in range(nx):
        value[i, i] = weights.terminal[i]
        value[i, nx] = weights.terminal[i] * (last[i] - weights.state_goal[i])
    if work.sizes.extra_cost + work.sizes.full_cost > 0:
        expand_beyond_diagonals(model, work, work.nominal.inputs.shape[0])
        for i in range(nx):
            value[i, nx] += work.node.gradient[i]
            for j in range(nx):
                value[i, j] += work.node.hessian[i, j]
    work.result.decrease = 0.0


@kernel
def value_behind(model: object, work: Workspace, node: int) -> None:
    """Value function of state node + 1 as the last sweep left it, or computed anew at the horizon's end."""
    if node == work.nominal.inputs.shape[0] - 1:
        terminal_value(model, work)
        work.policy.decreases[node + 1] = 0.0
        work.policy.costates[node + 1] = 0.0
    else:
        copy_rows(work.policy.values[node + 1], work.node.value)


@kernel
def penalize_state(work: Workspace, k: int, penalty: float) -> None:
    """Add the active rows and bounds of state k + 1 to its value function."""
    nx, last = work.sizes.states, k == work.nominal.inputs.shape[0] - 1
    value, linear, active, multipliers = work.node.value, work.linear, work.active, work.multipliers
    stiff = penalty * work.stiffness[k]
    for i in range(work.sizes.rows):
        if active.rows[k, i] != 0:
            row = linear.row_jacobians[k, i]
            row[nx] = multipliers.rows[k, i] / stiff + work.nominal.rows[k, i]
            add_square(work.tiles, k, work, row, stiff)
            row[nx] = 0.0
    if last:
        for i in range(work.sizes.end_rows):
            if active.end_rows[i] != 0:
                force = multipliers.end_rows[i] + penalty * work.nominal.end_rows[i]
                for a in range(nx):
                    slope = linear.end_row_jacobians[i, a]
                    value[a, nx] += slope * force
                    for b in range(nx):
                        value[a, b] += penalty * slope * linear.end_row_jacobians[i, b]
    if work.sizes.state_bounds > 0:
        x = work.nominal.states[k + 1]
        for i in range(nx):
            side = active.states[k, i]
            if side != 0:
                bound = work.limits.state_upper[i] if side > 0 else work.limits.state_lower[i]
                value[i, i] += stiff
                value[i, nx] += multipliers.states[k, i] + stiff * (x[i] - bound)


@kernel
def set_base(model: object, work: Workspace, k: int, penalty: float, regularization: float, afresh: bool) -> bool:
    """Cost of node k with its active mixed rows and bounds, into `node.base_x` and `node.base_u`."""
    nx, nu = work.sizes.states, work.sizes.inputs
    base_x, base_u, weights = work.node.base_x, work.node.base_u, work.weights
    if afresh:
        base_x[:, :] = 0.0
        base_u[:, :] = 0.0
        for i in range(nx):
            base_x[i, i] = weights.state[i]
        for i in range(nu):
            base_u[i, nx + 1 + i] = weights.input[i] + regularization * weights.metric[i]
    set_slopes(work.tiles, k, work)
    if work.sizes.extra_cost + work.sizes.full_cost > 0:
        add_stage_cost(model, work, k)
    if work.active.input_count[k] > 0:
        penalize_input(work, k, penalty)
    return work.sizes.extra_cost + work.sizes.full_cost > 0 or work.active.input_count[k] > 0


@kernel
def add_stage_cost(model: object, work: Workspace, k: int) -> None:
    """Add the model's own cost of node k, and the part of the quadratic cost off its diagonals."""
    nx, nu = work.sizes.states, work.sizes.inputs
    base_x, base_u, gradient, hessian = work.node.base_x, work.node.base_u, work.node.gradient, work.node.hessian
    expand_beyond_diagonals(model, work, k)
    for i in range(nx):
        base_x[i, nx] += gradient[i]
        for j in range(nx):
            base_x[i, j] += hessian[i, j]
    for i in range(nu):
        base_u[i, nx] += gradient[nx + i]
        for j in range(nx):
            base_u[i, j] += hessian[nx + i, j]
        for j in range(nu):
            base_u[i, nx + 1 + j] += hessian[nx + i, nx + j]


@kernel
def add_input_row(work: Workspace, row: Array, force: float, weight: float) -> None:
    """Add a mixed row to `node.base_x` and `node.base_u`."""
    nx, nu = work.sizes.states, work.sizes.inputs
    base_x, base_u = work.node.base_x, work.node.base_u
    row[nx] = force
    for a in range(nx):
        scale = weight * row[a]
        for b in range(nx + 1):
            base_x[a, b] += scale * row[b]
    for a in range(nu):
        scale = weight * row[nx + 1 + a]
        for b in range(nx + 1 + nu):
            base_u[a, b] += scale * row[b]
    row[nx] = 0.0


@kernel
def penalize_input(work: Workspace, k: int, penalty: float) -> None:
    """Add the active mixed rows and input bounds of node k to `node.base_x` and `node.base_u`."""
    nx, nu = work.sizes.states, work.sizes.inputs
    base_u, active, multipliers = work.node.base_u, work.active, work.multipliers
    for i in range(work.sizes.input_rows):
        if active.input_rows[k, i] != 0:
            row = work.linear.input_row_jacobians[k, i]
            add_input_row(work, row, multipliers.input_rows[k, i] / penalty + work.nominal.input_rows[k, i], penalty)
    if work.sizes.input_bounds > 0:
        u = work.nominal.inputs[k]
        for i in range(nu):
            side = active.inputs[k, i]
            if side != 0:
                bound = work.limits.input_upper[i] if side > 0 else work.limits.input_lower[i]
                base_u[i, nx + 1 + i] += penalty
                base_u[i, nx] += multipliers.inputs[k, i] + penalty * (u[i] - bound)


@kernel
def sweep(model: object, work: Workspace, penalty: float, regularization: float, last: int) -> bool:
    """Policy of the nodes up to `last` with the penalties of the active set; False if a Q_uu is not positive definite."""
    policy, afresh = work.policy, True
    value_behind(model, work, last)
    for k in range(last, -1, -1):
        if work.active.state_count[k] > 0:
            penalize_state(work, k, penalty)
        afresh = set_base(model, work, k, penalty, regularization, afresh)
        if not eliminate(work.tiles, k, work):
            return False
    work.result.decrease = 0.5 * policy.decreases[0]
    work.result.costate = policy.costates[0]
    return bool(abs(policy.decreases[0]) < np.inf)


@kernel
def step_along(work: Workspace) -> None:
    """Newton step of the last sweep into `trial`, with the rows linearised there."""
    nx, nominal, trial, step, linear = work.sizes.states, work.nominal, work.trial, work.node.step, work.linear
    largest = 0.0
    step[:] = 0.0
    for i in range(nx):
        trial.states[0, i] = nominal.states[0, i]
    for k in range(nominal.inputs.shape[0]):
        largest = max(largest, step_node(work.tiles, k, work))
    for i in range(work.sizes.end_rows):
        value = nominal.end_rows[i]
        for j in range(nx):
            value += linear.end_row_jacobians[i, j] * step[j]
        trial.end_rows[i] = value
    work.result.change = largest
