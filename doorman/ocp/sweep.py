r"""Riccati sweep of the augmented Lagrangian, and the step that follows from it.

Each row h ≤ 0 has a multiplier λ ≥ 0 and a penalty 1/μ; the active rows add :math:`h_x^T h_x/\mu` to V_xx and
:math:`h_x^T(\lambda + h/\mu)` to V_x of their state, g likewise to the node's cost, and bounds to a diagonal.
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.numba_types.lanes import load, multiply_rows, store
from doorman.ocp.functions import expand_end_cost, expand_stage_cost
from doorman.ocp.node_elimination import eliminate_inputs
from doorman.ocp.workspace import RESULT, Workspace


@kernel
def terminal_value(model: object, work: Workspace) -> None:
    """Value function of the last state; the sweep's sums to zero."""
    nx = len(work.sizes.states)
    last, weights, value = work.nominal.states[work.nominal.inputs.shape[0]], work.weights, work.node.value
    value[:, :] = 0.0
    for i in range(nx):
        value[i, i] = weights.terminal[i]
        value[i, nx] = weights.terminal[i] * (last[i] - weights.state_goal[i])
    if len(work.sizes.extra_cost) > 0:
        gradient, hessian = work.node.gradient[:nx], work.node.hessian[:nx, :nx].copy()
        gradient[:] = 0.0
        hessian[:, :] = 0.0
        expand_end_cost(model, last, gradient, hessian)
        for i in range(nx):
            value[i, nx] += gradient[i]
            for j in range(nx):
                value[i, j] += hessian[i, j]
    work.result[RESULT.DECREASE] = 0.0


@kernel
def penalize_state(work: Workspace, k: int, penalty: float) -> None:
    """Add the active rows and bounds of state k + 1 to its value function."""
    nx, last = len(work.sizes.states), k == work.nominal.inputs.shape[0] - 1
    value, linear, active, multipliers = work.node.value, work.linear, work.active, work.multipliers
    for i in range(len(work.sizes.rows)):
        if active.rows[k, i] != 0:
            row = linear.row_jacobians[k, i]
            row[nx] = multipliers.rows[k, i] / penalty + work.nominal.rows[k, i]
            for a in range(nx):
                scale = penalty * row[a]
                store(value, (a, 0), load(value, (a, 0), work.sizes.narrow) + scale * load(row, 0, work.sizes.narrow))
            row[nx] = 0.0
    if last:
        for i in range(len(work.sizes.end_rows)):
            if active.end_rows[i] != 0:
                force = multipliers.end_rows[i] + penalty * work.nominal.end_rows[i]
                for a in range(nx):
                    slope = linear.end_row_jacobians[i, a]
                    value[a, nx] += slope * force
                    for b in range(nx):
                        value[a, b] += penalty * slope * linear.end_row_jacobians[i, b]
    if len(work.sizes.state_bounds) > 0:
        x = work.nominal.states[k + 1]
        for i in range(nx):
            side = active.states[k, i]
            if side != 0:
                bound = work.limits.state_upper[i] if side > 0 else work.limits.state_lower[i]
                value[i, i] += penalty
                value[i, nx] += multipliers.states[k, i] + penalty * (x[i] - bound)


@kernel
def set_base(model: object, work: Workspace, k: int, penalty: float, regularization: float, afresh: bool) -> bool:
    """Cost of node k with its active mixed rows and bounds, into `node.base_x` and `node.base_u`.

    Args:
        model: The problem's model.
        work: Workspace.
        k: Node.
        penalty: 1/μ.
        regularization: Relative addition to the input weights.
        afresh: The buffers hold more than the quadratic cost of another node.

    Returns:
        Whether they do after this call.
    """
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    base_x, base_u, weights = work.node.base_x, work.node.base_u, work.weights
    x, u = work.nominal.states[k], work.nominal.inputs[k]
    if afresh:
        base_x[:, :] = 0.0
        base_u[:, :] = 0.0
        for i in range(nx):
            base_x[i, i] = weights.state[i]
        for i in range(nu):
            base_u[i, nx + 1 + i] = weights.input[i] * (1.0 + regularization)
    for i in range(nx):
        base_x[i, nx] = weights.state[i] * (x[i] - weights.state_goal[i])
    for i in range(nu):
        base_u[i, nx] = weights.input[i] * (u[i] - weights.input_goal[i])
    if len(work.sizes.extra_cost) > 0:
        add_stage_cost(model, work, k)
    if work.active.input_count[k] > 0:
        penalize_input(work, k, penalty)
    return len(work.sizes.extra_cost) > 0 or work.active.input_count[k] > 0


@kernel
def add_stage_cost(model: object, work: Workspace, k: int) -> None:
    """Add the model's own cost of node k."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    base_x, base_u, gradient, hessian = work.node.base_x, work.node.base_u, work.node.gradient, work.node.hessian
    gradient[:] = 0.0
    hessian[:, :] = 0.0
    expand_stage_cost(model, work.nominal.states[k], work.nominal.inputs[k], gradient, hessian)
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
def penalize_input(work: Workspace, k: int, penalty: float) -> None:
    """Add the active mixed rows and input bounds of node k."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    base_x, base_u, active, multipliers = work.node.base_x, work.node.base_u, work.active, work.multipliers
    for i in range(len(work.sizes.input_rows)):
        if active.input_rows[k, i] != 0:
            row = work.linear.input_row_jacobians[k, i]
            row[nx] = multipliers.input_rows[k, i] / penalty + work.nominal.input_rows[k, i]
            for a in range(nx):
                scale = penalty * row[a]
                for b in range(nx + 1):
                    base_x[a, b] += scale * row[b]
            for a in range(nu):
                scale = penalty * row[nx + 1 + a]
                for b in range(nx + 1 + nu):
                    base_u[a, b] += scale * row[b]
            row[nx] = 0.0
    if len(work.sizes.input_bounds) > 0:
        u = work.nominal.inputs[k]
        for i in range(nu):
            side = active.inputs[k, i]
            if side != 0:
                bound = work.limits.input_upper[i] if side > 0 else work.limits.input_lower[i]
                base_u[i, nx + 1 + i] += penalty
                base_u[i, nx] += multipliers.inputs[k, i] + penalty * (u[i] - bound)


@kernel
def sweep(model: object, work: Workspace, penalty: float, regularization: float) -> bool:
    """Policy of every node with the penalties of the active set; False if a Q_uu is not positive definite."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    node, decrease = work.node, 0.0
    terminal_value(model, work)
    afresh = True
    for k in range(work.nominal.inputs.shape[0] - 1, -1, -1):
        if work.active.state_count[k] > 0:
            penalize_state(work, k, penalty)
        afresh = set_base(model, work, k, penalty, regularization, afresh)
        if not eliminate_inputs(
            work.sizes, k, work.weights.time_step, work.linear.jacobians, node.value, node.base_x, node.base_u,
            work.policy.gains, work.policy.factors, node.rows, node.scaled,
        ):  # fmt: skip
            return False
        for a in range(nu):
            decrease += node.rows[a, nx] * node.scaled[a, nx]
    work.result[RESULT.DECREASE] = 0.5 * decrease
    return bool(np.isfinite(decrease))


@kernel
def step_along(work: Workspace, penalty: float) -> bool:
    """Newton step into `trial`, the rows linearised there into its constraints; whether the active set flipped.

    A row is active where λ + r/μ > 0 with r the linearised row at the step; `proposal` gets max(0, λ + r/μ).
    """
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    nominal, trial, step, weights = work.nominal, work.trial, work.node.step, work.weights
    flipped, largest = False, 0.0
    step[:] = 0.0
    for i in range(nx):
        trial.states[0, i] = nominal.states[0, i]
    for k in range(nominal.inputs.shape[0]):
        step[nx] = 1.0
        for i in range(nu):
            step[nx + 1 + i] = 0.0
        multiply_rows(work.policy.gains, k, work.sizes.inputs, work.sizes.narrow, step, step, nx + 1)
        for i in range(nu):
            largest = max(largest, weights.input[i] * abs(step[nx + 1 + i]))
            trial.inputs[k, i] = nominal.inputs[k, i] + step[nx + 1 + i]
        active = update_inputs(work, k, penalty)
        flipped |= active
        multiply_rows(work.linear.jacobians, k, work.sizes.states, work.sizes.wide, step, step, 0)
        for i in range(nx):
            trial.states[k + 1, i] = nominal.states[k + 1, i] + step[i]
        active = update_states(work, k, penalty)
        flipped |= active
    work.result[RESULT.CHANGE] = largest
    return flipped


@kernel
def update_row(multiplier: float, value: float, penalty: float, active: int) -> tuple[float, int, bool]:
    """Multiplier, activity and whether it flipped, of one row r = `value`."""
    force = multiplier + penalty * value
    now = 1 if force > 0.0 else 0
    return max(force, 0.0), now, now != active


@kernel
def update_bound(
    multiplier: float, value: float, lower: float, upper: float, penalty: float, side: int
) -> tuple[float, int, bool]:
    """Signed multiplier, side and whether it flipped, of one bounded number."""
    above, below = multiplier + penalty * (value - upper), multiplier + penalty * (value - lower)
    now = 1 if above > 0.0 else (-1 if below < 0.0 else 0)
    return max(above, 0.0) + min(below, 0.0), now, now != side


@kernel
def update_inputs(work: Workspace, k: int, penalty: float) -> bool:
    """Active set and proposed multipliers of the mixed rows and bounds of input k; whether any flipped."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    active, multipliers, proposal, step = work.active, work.multipliers, work.proposal, work.node.step
    flipped, count = False, 0
    for i in range(len(work.sizes.input_rows)):
        value, row = work.nominal.input_rows[k, i], work.linear.input_row_jacobians[k, i]
        for j in range(nx):
            value += row[j] * step[j]
        for j in range(nu):
            value += row[nx + 1 + j] * step[nx + 1 + j]
        proposal.input_rows[k, i], now, changed = update_row(
            multipliers.input_rows[k, i], value, penalty, active.input_rows[k, i]
        )
        active.input_rows[k, i] = now
        flipped |= changed
        count += now
    for i in range(len(work.sizes.input_bounds)):
        proposal.inputs[k, i], now, changed = update_bound(
            multipliers.inputs[k, i], work.trial.inputs[k, i], work.limits.input_lower[i], work.limits.input_upper[i],
            penalty, active.inputs[k, i],
        )  # fmt: skip
        active.inputs[k, i] = now
        flipped |= changed
        count += abs(now)
    active.input_count[k] = count
    return flipped


@kernel
def update_states(work: Workspace, k: int, penalty: float) -> bool:
    """Active set and proposed multipliers of the rows and bounds of state k + 1; whether any flipped."""
    nx, nh, last = len(work.sizes.states), len(work.sizes.rows), k == work.nominal.inputs.shape[0] - 1
    active, multipliers, proposal, step = work.active, work.multipliers, work.proposal, work.node.step
    flipped, count = False, 0
    if nh > 0:
        multiply_rows(
            work.linear.row_jacobians, k, work.sizes.rows, work.sizes.narrow, step, work.trial.rows.reshape(-1), k * nh
        )
    for i in range(nh):
        value = work.nominal.rows[k, i] + work.trial.rows[k, i]
        proposal.rows[k, i], now, changed = update_row(multipliers.rows[k, i], value, penalty, active.rows[k, i])
        active.rows[k, i] = now
        flipped |= changed
        count += now
    if last:
        for i in range(len(work.sizes.end_rows)):
            value = work.nominal.end_rows[i]
            for j in range(nx):
                value += work.linear.end_row_jacobians[i, j] * step[j]
            proposal.end_rows[i], now, changed = update_row(multipliers.end_rows[i], value, penalty, active.end_rows[i])
            active.end_rows[i] = now
            flipped |= changed
            count += now
    for i in range(len(work.sizes.state_bounds)):
        proposal.states[k, i], now, changed = update_bound(
            multipliers.states[k, i], work.trial.states[k + 1, i], work.limits.state_lower[i],
            work.limits.state_upper[i], penalty, active.states[k, i],
        )  # fmt: skip
        active.states[k, i] = now
        flipped |= changed
        count += abs(now)
    active.state_count[k] = count
    return flipped
