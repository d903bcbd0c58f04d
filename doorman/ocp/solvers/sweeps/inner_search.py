r"""Exact line search between two sweeps on one linearisation.

With the dynamics linearised, the augmented Lagrangian is convex and piecewise quadratic. The step d of a sweep minimises it for
an active set that may not be the one at its end; what it is worth is found along :math:`z + \tau d`, where its slope

.. math:: \varphi'(\tau) = q_0 + q_1\tau + \sum_i \max(0,\ \lambda_i + r_i(\tau)/\mu)\,\dot r_i

rises with τ: q is the quadratic cost, and the rows r are linear in τ. With it repeated sweeps cannot cycle (a semismooth Newton
method with exact line search; compare Hermans, Themelis and Patrinos 2019).
"""

from __future__ import annotations

from doorman.compilation import kernel
from doorman.ocp.solvers.memory.parts import Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.flat_rows import flatten_multipliers, flatten_values
from doorman.ocp.solvers.sweeps.full_weights import expand_beyond_diagonals
from doorman.ocp.solvers.sweeps.linear_algebra import go_between

_STEPS = 40
_CLOSE = 1e-12
"""Width of an interval that is good enough."""


@kernel
def best_part(model: object, work: Workspace, base: Trajectory, penalty: float) -> float:
    """τ in (0, 1] that minimises the augmented Lagrangian from `base` to the trial trajectory.

    Its slope rises along straight pieces: false position, halving the end that stays (Illinois), finds the zero in few steps.
    """
    flatten_values(work, base, work.flat.others)
    flatten_values(work, work.trial, work.flat.values)
    flatten_multipliers(work, work.multipliers, work.flat.prices)
    first, second = cost_slope(model, work, base)
    above = first + second + row_slope(work, penalty, 1.0)
    below = first + row_slope(work, penalty, 0.0)
    if not above > 0.0:
        return 1.0
    if not below < 0.0:
        return 0.0
    low, high, stayed = 0.0, 1.0, 0
    for _ in range(_STEPS):
        part = (low * above - high * below) / (above - below)
        slope = first + second * part + row_slope(work, penalty, part)
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
    nx, n, nominal, trial = work.sizes.states, work.trial.inputs.shape[0], work.nominal, work.trial
    gradient, hessian, size = work.node.gradient, work.node.hessian, nx + work.sizes.inputs if k < n else nx
    expand_beyond_diagonals(model, work, k)
    first, second = 0.0, 0.0
    for i in range(size):
        change, slope = entry(trial, base, k, i, nx), gradient[i]
        for j in range(size):
            slope += hessian[i, j] * entry(base, nominal, k, j, nx)
            second += change * hessian[i, j] * entry(trial, base, k, j, nx)
        first += slope * change
    return first, second


@kernel
def entry(one: Trajectory, other: Trajectory, k: int, i: int, nx: int) -> float:
    """Difference of two trajectories in a number of node k."""
    if i < nx:
        return float(one.states[k, i] - other.states[k, i])
    return float(one.inputs[k, i - nx] - other.inputs[k, i - nx])


@kernel
def row_slope(work: Workspace, penalty: float, part: float) -> float:
    """Share of the rows in the slope φ'(τ), between `flat.others` and `flat.values`."""
    flat, total = work.flat, 0.0
    for k in range(flat.values.shape[0]):
        for i in range(flat.values.shape[1]):
            if flat.applies[k, i]:
                change = flat.values[k, i] - flat.others[k, i]
                force = flat.prices[k, i] + penalty * flat.stiffness[k, i] * (flat.others[k, i] + part * change)
                total += force * change if flat.equal[i] else max(0.0, force) * change
    return total


@kernel
def shorten(work: Workspace, base: Trajectory, part: float) -> None:
    """Move the trial trajectory and its rows back to a share of its way from `base`."""
    trial = work.trial
    go_between(base.states, trial.states, part, trial.states)
    go_between(base.inputs, trial.inputs, part, trial.inputs)
    go_between(base.rows, trial.rows, part, trial.rows)
    go_between(base.input_rows, trial.input_rows, part, trial.input_rows)
    for i in range(trial.end_rows.shape[0]):
        trial.end_rows[i] = base.end_rows[i] + part * (trial.end_rows[i] - base.end_rows[i])
