r"""The careful phase of the augmented Lagrangian: a merit function, and multipliers that move only once a step has settled.

For the present multipliers and penalty, steps have to lower

.. math:: m = J + \tfrac{\mu}{2}\sum_i\big(\max(0, \lambda_i + h_i/\mu)^2 - \lambda_i^2\big) + \rho\,\lVert e\rVert_1

by Armijo's rule, ρ above the largest costate. Multipliers and penalty follow the rules of bound-constrained Lagrangian methods
(Conn, Gould and Toint 1991). Slower than `augmented_lagrangian.iterate`, and reliable where that is not.
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.numba_types.lanes import clock
from doorman.ocp.augmented_lagrangian import (
    CONVERGED,
    FAILED,
    OUT_OF_ITERATIONS,
    STALLED,
    direction,
    is_small,
    linearize,
    measure_nominal,
    move,
    save,
    take_multipliers,
    total_cost,
)
from doorman.ocp.linear_algebra import copy_rows
from doorman.ocp.sweep import classify
from doorman.ocp.workspace import RESULT, Workspace

_FIRST_PENALTY = 30.0
_LARGEST_PENALTY = 1e5
_SWEEPS = 12
_FIRST_SETTLED = 0.1
"""A step with a smaller predicted decrease, relative to 1 + |J|, moves the multipliers; a tenth of it the next time."""
_SMALLEST_SCALE = 1.0 / 256.0
_FIRST_REGULARIZATION = 1e-2
_LARGEST_REGULARIZATION = 1e8


@kernel
def merit(model: object, work: Workspace, penalty: float, weight: float) -> float:
    """Merit of the nominal trajectory after its linearisation; its cost into `result`."""
    nominal, multipliers, limits = work.nominal, work.multipliers, work.limits
    nx, total, defects = len(work.sizes.states), 0.0, 0.0
    for k in range(nominal.inputs.shape[0]):
        for i in range(len(work.sizes.rows)):
            total += squared(multipliers.rows[k, i], nominal.rows[k, i], penalty)
        for i in range(len(work.sizes.input_rows)):
            total += squared(multipliers.input_rows[k, i], nominal.input_rows[k, i], penalty)
        for i in range(len(work.sizes.state_bounds)):
            x, multiplier = nominal.states[k + 1, i], multipliers.states[k, i]
            total += squared_bound(multiplier, x - limits.state_upper[i], limits.state_lower[i] - x, penalty)
        for i in range(len(work.sizes.input_bounds)):
            u, multiplier = nominal.inputs[k, i], multipliers.inputs[k, i]
            total += squared_bound(multiplier, u - limits.input_upper[i], limits.input_lower[i] - u, penalty)
        for i in range(nx):
            defects += abs(work.linear.jacobians[k, i, nx])
    for i in range(len(work.sizes.end_rows)):
        total += squared(multipliers.end_rows[i], nominal.end_rows[i], penalty)
    work.result[RESULT.COST] = total_cost(model, work, nominal)
    return float(work.result[RESULT.COST] + 0.5 * total / penalty + weight * defects)


@kernel
def squared(multiplier: float, value: float, penalty: float) -> float:
    """max(0, λ + h/μ)² − λ²."""
    force = max(0.0, multiplier + penalty * value)
    return force * force - multiplier * multiplier


@kernel
def squared_bound(multiplier: float, above: float, below: float, penalty: float) -> float:
    """The same of a number with a bound at either end, and a signed multiplier."""
    upper, lower = max(0.0, multiplier + penalty * above), max(0.0, -multiplier + penalty * below)
    return upper * upper + lower * lower - multiplier * multiplier


@kernel
def descend(model: object, work: Workspace, penalty: float, weight: float, before: float) -> float:
    """Shorten the step in `trial` until the merit has fallen enough; its length, or 0 with everything as it was."""
    expected = work.result[RESULT.DECREASE]
    save(work)
    scale = 1.0
    while scale >= _SMALLEST_SCALE:
        move(work, scale)
        linearize(model, work)
        reached = merit(model, work, penalty, weight)
        if reached <= before - 1e-4 * scale * expected + 1e-12 * (1.0 + abs(before)):
            return scale
        scale *= 0.5
    copy_rows(work.saved.states, work.nominal.states)
    copy_rows(work.saved.inputs, work.nominal.inputs)
    linearize(model, work)
    return 0.0


@kernel
def iterate_carefully(model: object, work: Workspace, max_iterations: int, deadline: float) -> int:
    """Iterate from the nominal trajectory and the multipliers in `work`; see `augmented_lagrangian.iterate`."""
    result, tolerance = work.result, work.settings.tolerance
    penalty, settle, regularization = _FIRST_PENALTY, _FIRST_SETTLED, 0.0
    weight, last_violation = 0.0, np.inf
    result[RESULT.PRICED_OUT] = 0.0
    linearize(model, work)
    for iteration in range(max_iterations):
        result[RESULT.ITERATIONS] = iteration + 1.0
        measure_nominal(work)
        classify(work, work.nominal, penalty)
        settled = direction(model, work, penalty, _SWEEPS, regularization)
        if settled < 0 or not abs(result[RESULT.INFEASIBILITY] + result[RESULT.CHANGE]) < np.inf:
            return FAILED
        weight = max(weight, 1.5 * result[RESULT.COSTATE])
        before = merit(model, work, penalty, weight)
        expected, violation = result[RESULT.DECREASE], result[RESULT.VIOLATION]
        converged = settled == 1 and regularization == 0.0 and is_small(work, tolerance)
        if converged or clock() > deadline:
            save(work)
            move(work, 1.0)
            take_multipliers(work, 1.0)
            return CONVERGED if converged else OUT_OF_ITERATIONS
        scale = descend(model, work, penalty, weight, before)
        if scale == 0.0:
            regularization = max(10.0 * regularization, _FIRST_REGULARIZATION)
            if regularization > _LARGEST_REGULARIZATION:
                return STALLED
            continue
        regularization = 0.0 if regularization <= _FIRST_REGULARIZATION else 0.1 * regularization
        if scale == 1.0 and settled == 1 and expected <= settle * (1.0 + abs(result[RESULT.COST])):
            take_multipliers(work, 1.0)
            settle = max(0.1 * settle, tolerance)
            if violation > 0.25 * last_violation and violation > np.sqrt(tolerance):
                penalty = min(4.0 * penalty, _LARGEST_PENALTY)
            last_violation = violation
    return OUT_OF_ITERATIONS
