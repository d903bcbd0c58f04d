r"""Exact line search between two sweeps on one linearisation.

With the dynamics linearised, the augmented Lagrangian is convex and piecewise quadratic. The step d of a sweep minimises it for
an active set that may not be the one at its end; what it is worth is found along :math:`z + \tau d`, where its slope

.. math:: \varphi'(\tau) = q_0 + q_1\tau + \sum_i \max(0,\ \lambda_i + r_i(\tau)/\mu)\,\dot r_i

rises with τ: q is the quadratic cost, and the rows r are linear in τ. With it repeated sweeps cannot cycle (a semismooth Newton
method with exact line search; compare Hermans, Themelis and Patrinos 2019).
"""

from __future__ import annotations

from doorman.compilation import kernel
from doorman.ocp.kernels.functions import at_node, expand_end_cost, expand_stage_cost
from doorman.ocp.solvers.memory.parts import Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.full_weights import off_diagonal_curvature, off_diagonal_slope

_STEPS = 40
_CLOSE = 1e-12
"""Width of an interval that is good enough."""


@kernel
def best_part(model: object, work: Workspace, base: Trajectory, penalty: float) -> float:
    """τ in (0, 1] that minimises the augmented Lagrangian from `base` to the trial trajectory.

    Its slope rises along straight pieces: false position, halving the end that stays (Illinois), finds the zero in few steps.
    """
    first, second = cost_slope(model, work, base)
    above = first + second + row_slope(work, base, penalty, 1.0)
    below = first + row_slope(work, base, penalty, 0.0)
    if not above > 0.0:
        return 1.0
    if not below < 0.0:
        return 0.0
    low, high, stayed = 0.0, 1.0, 0
    for _ in range(_STEPS):
        part = (low * above - high * below) / (above - below)
        slope = first + second * part + row_slope(work, base, penalty, part)
        if slope > 0.0:
            below *= 0.5 if stayed == -1 else 1.0
            high, above, stayed = part, slope, -1
        else:
            above *= 0.5 if stayed == 1 else 1.0
            low, below, stayed = part, slope, 1
        if high - low < _CLOSE or slope == 0.0:
            break
    return 0.5 * (low + high)


@kernel
def cost_slope(model: object, work: Workspace, base: Trajectory) -> tuple[float, float]:
    """Slope q_0 of the quadratic model of the cost at `base` towards the trial trajectory, and its growth q_1 with τ."""
    nx, nu = work.sizes.states, work.sizes.inputs
    trial, weights, n = work.trial, work.weights, work.trial.inputs.shape[0]
    first, second = 0.0, 0.0
    for k in range(n + 1):
        for i in range(nx):
            weight = weights.state[i] if k < n else weights.terminal[i]
            change = trial.states[k, i] - base.states[k, i]
            first += weight * (base.states[k, i] - weights.state_goal[i]) * change
            second += weight * change * change
        for i in range(nu if k < n else 0):
            change = trial.inputs[k, i] - base.inputs[k, i]
            first += weights.input[i] * (base.inputs[k, i] - weights.input_goal[i]) * change
            second += weights.input[i] * change * change
    if work.sizes.extra_cost + work.sizes.full_cost > 0:
        for k in range(n + 1):
            linear, curved = extra_slope(model, work, base, k)
            first += linear
            second += curved
    return first, second


@kernel
def extra_slope(model: object, work: Workspace, base: Trajectory, k: int) -> tuple[float, float]:
    """Slope of the cost beyond its diagonals at node k, and its growth with τ.

    The cost is expanded along the nominal trajectory.
    """
    nx, nu, n = work.sizes.states, work.sizes.inputs, work.trial.inputs.shape[0]
    gradient, hessian, nominal, trial = work.node.gradient, work.node.hessian, work.nominal, work.trial
    size = nx + nu if k < n else nx
    for i in range(nx + nu):
        gradient[i] = 0.0
        for j in range(nx + nu):
            hessian[i, j] = 0.0
    if work.sizes.extra_cost == 0:
        pass
    elif k < n:
        expand_stage_cost(at_node(model, k), nominal.states[k], nominal.inputs[k], gradient, hessian)
    else:
        corner = hessian[:nx, :nx].copy()
        expand_end_cost(at_node(model, k), nominal.states[k], gradient[:nx], corner)
        for i in range(nx):
            for j in range(nx):
                hessian[i, j] = corner[i, j]
    if work.sizes.full_cost > 0:
        off_diagonal_slope(work, nominal, k, gradient)
        off_diagonal_curvature(work, k, hessian)
    first, second = 0.0, 0.0
    for i in range(size):
        change = trial.states[k, i] - base.states[k, i] if i < nx else trial.inputs[k, i - nx] - base.inputs[k, i - nx]
        slope = gradient[i]
        for j in range(size):
            off = (
                base.states[k, j] - nominal.states[k, j]
                if j < nx
                else base.inputs[k, j - nx] - nominal.inputs[k, j - nx]
            )
            other = (
                trial.states[k, j] - base.states[k, j] if j < nx else trial.inputs[k, j - nx] - base.inputs[k, j - nx]
            )
            slope += hessian[i, j] * off
            second += change * hessian[i, j] * other
        first += slope * change
    return first, second


@kernel
def row_slope(work: Workspace, base: Trajectory, penalty: float, part: float) -> float:
    """Share of the rows in the slope φ'(τ)."""
    trial, multipliers, limits = work.trial, work.multipliers, work.limits
    floors, total = work.floors, 0.0
    for k in range(trial.inputs.shape[0]):
        stiff = penalty * work.stiffness[k]
        for i in range(work.sizes.rows):
            change = trial.rows[k, i] - base.rows[k, i]
            force = multipliers.rows[k, i] + stiff * (base.rows[k, i] + part * change)
            total += max(floors.rows[i], force) * change
        for i in range(work.sizes.input_rows):
            change = trial.input_rows[k, i] - base.input_rows[k, i]
            force = multipliers.input_rows[k, i] + penalty * (base.input_rows[k, i] + part * change)
            total += max(floors.input_rows[i], force) * change
        if work.sizes.state_bounds > 0:
            for i in range(work.sizes.states):
                change = trial.states[k + 1, i] - base.states[k + 1, i]
                x = base.states[k + 1, i] + part * change
                above = max(0.0, multipliers.states[k, i] + stiff * (x - limits.state_upper[i]))
                below = min(0.0, multipliers.states[k, i] + stiff * (x - limits.state_lower[i]))
                total += (above + below) * change
        if work.sizes.input_bounds > 0:
            for i in range(work.sizes.inputs):
                change = trial.inputs[k, i] - base.inputs[k, i]
                u = base.inputs[k, i] + part * change
                above = max(0.0, multipliers.inputs[k, i] + penalty * (u - limits.input_upper[i]))
                below = min(0.0, multipliers.inputs[k, i] + penalty * (u - limits.input_lower[i]))
                total += (above + below) * change
    for i in range(work.sizes.end_rows):
        change = trial.end_rows[i] - base.end_rows[i]
        force = multipliers.end_rows[i] + penalty * (base.end_rows[i] + part * change)
        total += max(floors.end_rows[i], force) * change
    return total


@kernel
def shorten(work: Workspace, base: Trajectory, part: float) -> None:
    """Move the trial trajectory and its rows back to a share of its way from `base`."""
    trial = work.trial
    shorten_rows(trial.states, base.states, part)
    shorten_rows(trial.inputs, base.inputs, part)
    shorten_rows(trial.rows, base.rows, part)
    shorten_rows(trial.input_rows, base.input_rows, part)
    for i in range(trial.end_rows.shape[0]):
        trial.end_rows[i] = base.end_rows[i] + part * (trial.end_rows[i] - base.end_rows[i])


@kernel
def shorten_rows(values: object, base: object, part: float) -> None:
    """Move a matrix back to a share of its way from another."""
    for k in range(values.shape[0]):  # type: ignore[attr-defined]
        for i in range(values.shape[1]):  # type: ignore[attr-defined]
            values[k, i] = base[k, i] + part * (values[k, i] - base[k, i])  # type: ignore[index]
