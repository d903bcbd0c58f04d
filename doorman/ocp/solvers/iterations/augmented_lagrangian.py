r"""Semismooth augmented Lagrangian iterations on the multiple-shooting form, with a filter line search.

States and inputs are variables, defects :math:`e_k = f(x_k,u_k) - x_{k+1}` stay in the affine term of a Gauss-Newton model.
After a sweep the whole active set flips to {λ + r/μ > 0} with the linearised rows r, a semismooth Newton step. If it
changed, the sweep is repeated on the same linearisation, from the best point on the way (`inner_search`). A step is accepted
where it lowers the infeasibility θ = Σ|e| + Σ max(0, h) or the cost, compared with all pairs (θ, J) that the search has left;
otherwise it is halved. Methods: Jallet et al. 2022 (proximal AL DDP); Hintermüller, Ito and Kunisch 2003 (active sets);
Fletcher and Leyffer 2002 (filter).
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.ocp.solvers.iterations.filter import MARGIN, is_new, remember
from doorman.ocp.solvers.iterations.nominal import (
    go_back,
    linearize,
    measure_nominal,
    move,
    save,
    take_multipliers,
    total_cost,
)
from doorman.ocp.solvers.memory.workspace import Workspace, copy_trajectory
from doorman.ocp.solvers.sweeps.active_set import classify
from doorman.ocp.solvers.sweeps.flat_rows import flatten_multipliers, flatten_values
from doorman.ocp.solvers.sweeps.inner_search import best_part, shorten
from doorman.ocp.solvers.sweeps.sweep import step_along, sweep

CONVERGED = 0
OUT_OF_ITERATIONS = 1
FAILED = 2
STALLED = 3
PAUSED = 4

ACCURACY = 1e-7
"""Accuracy of a solution's cost, relative to 1 + |J|. An iterate has converged only if its rows with a multiplier that are not
reached, or are violated, are worth less."""

_HALVINGS = 8
_PATIENCE = 3
"""Iterations after which a set that has not settled gets twice as many sweeps, and twice again, up to"""
_MOST_SWEEPS = 32
_FLIPS = 8
"""Sweeps after which the active set does not flip as a whole any more."""
_FIRST_REGULARIZATION = 1e-2
_LARGEST_REGULARIZATION = 1e8
_RETRIES = 12
"""Sweeps until the regularisation is beyond that."""


@kernel
def direction(
    model: object, work: Workspace, penalty: float, sweeps: int, regularization: float, deadline: float
) -> bool:
    """Step into `trial` for the active set that fits it, if `result.settled` says so; False if no sweep goes through.

    The set flips as a whole at first, which settles it in a few sweeps or in none; then the step is cut at its best point.
    """
    end = work.nominal.inputs.shape[0] - 1
    last = end
    work.result.settled = False
    for turn in range(sweeps):
        work.result.sweeps += 1
        for _ in range(_RETRIES):
            if sweep(model, work, penalty, regularization, last):
                break
            last, regularization = end, max(10.0 * regularization, _FIRST_REGULARIZATION)
            if regularization > _LARGEST_REGULARIZATION:
                return False
        step_along(work)
        last = classify(work, work.trial, penalty)
        if last < 0:
            work.result.settled = True
            return True
        if clock() > deadline:
            break
        if turn > _FLIPS:  # both ends satisfy the linearised dynamics, as the nominal trajectory need not
            part = best_part(model, work, work.saved, penalty)
            if part < 1.0:
                shorten(work, work.saved, part)
                last = max(last, classify(work, work.trial, penalty))
        if turn >= _FLIPS:
            copy_trajectory(work.trial, work.saved)
    return True


@kernel
def search(model: object, work: Workspace, deadline: float) -> float:
    """Shorten the step in `trial` until the filter accepts it."""
    save(work)
    scale = 1.0
    for _ in range(_HALVINGS):
        move(work, scale)
        linearize(model, work)
        measure_nominal(work)
        cost = total_cost(model, work, work.nominal)
        if is_new(work.filter, work.result.infeasibility, cost, MARGIN, 1e-11 * (1.0 + abs(cost))):
            work.result.cost = cost
            take_multipliers(work, scale)
            return scale
        if clock() > deadline:
            break
        scale *= 0.5
    go_back(model, work)
    measure_nominal(work)
    return 0.0


@kernel
def iterate(model: object, work: Workspace, max_iterations: int, deadline: float) -> int:
    """Iterate from the nominal trajectory and the multipliers in `work`.

    An iterate has converged if its sweep predicts a smaller decrease than `settings.tolerance`, relative to 1 and the magnitude
    of J, its active set stays, and its rows with a multiplier are closed. Defects and violations are below the tolerance's
    square root then; violations may stay where multipliers have reached `settings.largest_multiplier`.
    """
    result, tolerance, first = work.result, work.settings.tolerance, 0
    before, slowest = clock(), 0.0
    if result.resumes:
        first = result.iterations
    else:
        result.penalty, result.regularization = work.settings.penalty, 0.0
        result.iterations, result.sweep_limit, result.priced_out = 0, work.settings.sweeps, False
        work.filter.count = 0
        linearize(model, work)
        classify(work, work.nominal, result.penalty)
        if max_iterations > 1:
            measure_nominal(work)
            result.cost = total_cost(model, work, work.nominal)
            if not abs(result.infeasibility + result.cost) < np.inf:
                return FAILED
    for iteration in range(first, max_iterations):
        if iteration > first and clock() > result.pause:
            return PAUSED
        result.iterations = iteration + 1
        limit, regularization = deadline if iteration > 0 else np.inf, result.regularization
        if not direction(model, work, result.penalty, result.sweep_limit, regularization, limit):
            return FAILED
        if not result.change < 1e12:
            return FAILED
        converged = result.settled and regularization == 0.0 and is_small(work, tolerance)
        now = clock()
        before, slowest = now, max(slowest, now - before)
        if converged or iteration + 1 == max_iterations or now + slowest > deadline:
            save(work)
            move(work, 1.0)
            take_multipliers(work, 1.0)
            return CONVERGED if converged else OUT_OF_ITERATIONS
        violation = result.violation
        remember(work.filter, result.infeasibility, result.cost)
        scale = search(model, work, deadline)
        if not regularize(work, scale > 0.0):
            return STALLED
        if scale == 0.0:
            work.filter.count -= 1
        else:
            slow = violation > tolerance and result.violation > 0.5 * violation
            if scale == 1.0 and result.settled and slow and not result.priced_out:
                result.penalty = min(4.0 * result.penalty, 1e7)
        if result.settled:
            result.sweep_limit = work.settings.sweeps
        elif scale < 1.0 or iteration >= _PATIENCE:
            result.sweep_limit = min(2 * result.sweep_limit, _MOST_SWEEPS)
    return OUT_OF_ITERATIONS


@kernel
def regularize(work: Workspace, stepped: bool) -> bool:
    """Less regularisation after a step, more where none was found; False if that is too much."""
    now = work.result.regularization
    if stepped:
        work.result.regularization = 0.0 if now <= _FIRST_REGULARIZATION else 0.1 * now
    else:
        work.result.regularization = max(10.0 * now, _FIRST_REGULARIZATION)
    return bool(work.result.regularization <= _LARGEST_REGULARIZATION)


@kernel
def is_small(work: Workspace, tolerance: float) -> bool:
    """Whether the last step, its starting point, and what its rows could still gain are small enough to end with it."""
    result = work.result
    limit, scale = np.sqrt(tolerance), 1.0 + abs(result.cost)
    if result.decrease > tolerance * scale:
        return False
    if result.priced_out:
        return bool(result.defect <= limit)
    return bool(result.infeasibility <= limit and slack(work) <= ACCURACY * scale)


@kernel
def slack(work: Workspace) -> float:
    """Sum Σ λ max(0, −r) of the step in `trial`: what it would gain by going up to all rows that have a multiplier.

    Of an equality, the magnitude of λ r.
    """
    flat, total = work.flat, 0.0
    flatten_values(work, work.trial, flat.values)
    flatten_multipliers(work, work.proposal, flat.prices)
    for k in range(flat.values.shape[0]):
        for i in range(flat.values.shape[1]):
            if flat.applies[k, i]:
                value, price = flat.values[k, i], flat.prices[k, i]
                total += abs(price * value) if flat.equal[i] else max(0.0, price) * max(0.0, -value)
    return float(total)
