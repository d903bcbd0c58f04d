r"""Interior-point iterations on the multiple-shooting form, with exact Hessians and a filter line search.

Where dynamics bend much, the curvature of the dynamics decides which minimum a path leads to, and Gauss and Newton's Hessian
has none of it. The barrier problems

.. math:: \min\ J - \tau \textstyle\sum_i \ln s_i\quad\text{s.t.}\quad e = 0,\ c + s = 0

are solved for a falling τ. Equalities have an augmented Lagrangian Σ (y c + w c²/2) in J, whose y and w move with τ: from a
guess that cannot reach them to first order, Newton's step for c = 0 is of no use. A step is accepted where it lowers the
infeasibility θ = Σ|e| + Σ|c + s| or the barrier function φ, compared with all pairs that the search has left behind. Methods:
Wächter and Biegler 2006 (barrier, filter, regularisation); Vanroye et al. 2023 (the same by Riccati sweeps).
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.ocp.solvers.interior import newton, rows
from doorman.ocp.solvers.interior.memory import Interior
from doorman.ocp.solvers.iterations.augmented_lagrangian import CONVERGED, FAILED, OUT_OF_ITERATIONS, PAUSED, STALLED
from doorman.ocp.solvers.iterations.filter import MARGIN, is_new, remember
from doorman.ocp.solvers.iterations.guess import settle_integrators
from doorman.ocp.solvers.iterations.nominal import go_back, linearize, measure_nominal, save
from doorman.ocp.solvers.memory.workspace import Workspace

_TOLERANCE = 1e-7
"""Largest residual of a solution, in units of the scaled cost."""
_CENTRED = 10.0
"""A barrier problem is solved up to so many τ."""
_MARGIN_COST = 1e-8
_HALVINGS = 20
_LOWERINGS = 16
"""Barrier problems until the barrier is as low as it gets."""
_FIRST_REGULARIZATION = 1e-4
_LARGEST_REGULARIZATION = 1e12
_SWEEPS = 32
"""Sweeps until the regularisation is beyond that."""
_STEPPED = -1


@kernel
def search(model: object, work: Workspace, interior: Interior, max_iterations: int, deadline: float) -> int:
    """Iterate from the nominal trajectory; multipliers of a solution are in `work`."""
    numbers, result = interior.numbers, work.result
    begun, slowest, first = clock(), 0.0, 0
    if result.resumes:
        first = result.iterations
    else:
        begin(model, work, interior)
    for iteration in range(first, max_iterations):
        if iteration > first and clock() > result.pause:
            measure_nominal(work)
            return PAUSED
        now = clock()
        begun, slowest = now, max(slowest, now - begun)
        if iteration > 0 and now + slowest > deadline:
            return OUT_OF_ITERATIONS
        if not abs(numbers.infeasibility + numbers.barrier_cost) < np.inf:
            return FAILED
        newton.expand(model, work, interior)
        if iteration == 0:
            rows.first_slacks(work, interior)
            rows.measure(model, work, interior)
            numbers.first = numbers.infeasibility
            damp(work, interior)
        elif rows.error(work, interior, 0.0) <= _TOLERANCE:
            rows.export_multipliers(work, interior)
            return CONVERGED
        else:
            lower_barrier(model, work, interior)
        result.iterations = iteration + 1
        code = descend(model, work, interior, iteration == 0, deadline)
        if code == PAUSED:
            result.iterations = iteration
            measure_nominal(work)
        if code != _STEPPED:
            return code
    return OUT_OF_ITERATIONS


@kernel
def begin(model: object, work: Workspace, interior: Interior) -> None:
    """Prepare the search: inputs inside their bounds, a linearisation, and costates and multipliers of zero."""
    rows.push_inside(work)
    settle_integrators(work)
    linearize(model, work)
    rows.fill_values(work, interior)
    interior.costates[:, :] = 0.0
    interior.duals[:, :] = 0.0
    interior.estimates[:, :] = 0.0
    interior.filter.count = 0
    interior.numbers.infeasibility, interior.numbers.barrier_cost, interior.numbers.tried = 0.0, 0.0, 0.0
    work.result.iterations, work.result.regularization = 0, 0.0


@kernel
def damp(work: Workspace, interior: Interior) -> None:
    """Damp the first steps by the bounds of inputs that an undamped one would cross."""
    regularization = 0.0
    for _ in range(_SWEEPS):
        if newton.sweep(work, interior, regularization):
            newton.step_along(work, interior)
            rows.raise_reached(work, interior)
            return
        regularization = max(100.0 * regularization, _FIRST_REGULARIZATION * interior.numbers.scale)


@kernel
def lower_barrier(model: object, work: Workspace, interior: Interior) -> None:
    """Go on to the next barrier problem where the present one is solved."""
    numbers, scale = interior.numbers, interior.numbers.scale
    least = 0.1 * _TOLERANCE * scale
    for _ in range(_LOWERINGS):
        barrier = numbers.barrier
        lowest = barrier <= least
        if (lowest and work.sizes.equalities == 0) or rows.error(work, interior, barrier) > _CENTRED * barrier / scale:
            return
        if not lowest:
            numbers.barrier = max(least, min(0.2 * barrier, scale * (barrier / scale) ** 1.5))
        if work.sizes.equalities > 0:
            rows.move_estimates(work, interior)
        interior.filter.count = 0
        rows.measure(model, work, interior)


@kernel
def descend(model: object, work: Workspace, interior: Interior, first: bool, deadline: float) -> int:
    """One step, with as much regularisation as it takes."""
    numbers, scale, last = interior.numbers, interior.numbers.scale, work.result.regularization
    regularization = numbers.tried
    numbers.tried = 0.0
    for _ in range(_SWEEPS):
        if newton.sweep(work, interior, regularization):
            newton.step_along(work, interior)
            if search_line(model, work, interior, first, deadline):
                if regularization > 0.0:
                    work.result.regularization = regularization
                return _STEPPED
        if regularization == 0.0:
            regularization = _FIRST_REGULARIZATION * scale if last == 0.0 else max(last / 3.0, 1e-12 * scale)
        else:
            regularization *= 8.0 if last > 0.0 else 100.0
        now = clock()
        if not regularization <= _LARGEST_REGULARIZATION * scale or now > deadline:
            break
        if now > work.result.pause > 0.0:
            numbers.tried = regularization
            return PAUSED
    return STALLED


@kernel
def search_line(model: object, work: Workspace, interior: Interior, first: bool, deadline: float) -> bool:
    """Shorten the Newton step until the filter accepts it."""
    numbers = interior.numbers
    infeasibility, merit = numbers.infeasibility, numbers.barrier_cost
    save(work)
    length = numbers.primal
    part = length
    for _ in range(_HALVINGS):
        move(work, interior, part)
        linearize(model, work)
        rows.fill_values(work, interior)
        move_slacks(work, interior, part)
        rows.measure(model, work, interior)
        if is_better(interior, infeasibility, merit, part):
            take_multipliers(work, interior, 1.0 if first else part)
            return True
        move_slacks(work, interior, -part)
        if clock() > deadline:
            break
        part *= 0.5
    go_back(model, work)
    rows.fill_values(work, interior)
    numbers.infeasibility, numbers.barrier_cost = infeasibility, merit
    return False


@kernel
def move(work: Workspace, interior: Interior, part: float) -> None:
    """Set the nominal trajectory to `saved` plus a share of the step."""
    nominal, saved = work.nominal, work.saved
    for k in range(nominal.inputs.shape[0]):
        for i in range(work.sizes.inputs):
            nominal.inputs[k, i] = saved.inputs[k, i] + part * interior.input_steps[k, i]
        for i in range(work.sizes.states):
            nominal.states[k + 1, i] = saved.states[k + 1, i] + part * interior.state_steps[k + 1, i]


@kernel
def move_slacks(work: Workspace, interior: Interior, part: float) -> None:
    """Move the slacks by a share of their step."""
    for k in range(interior.slacks.shape[0]):
        for i in range(interior.slacks.shape[1]):
            if work.flat.applies[k, i] and not work.flat.equal[i]:
                interior.slacks[k, i] += part * interior.slack_steps[k, i]


@kernel
def take_multipliers(work: Workspace, interior: Interior, part: float) -> None:
    """Move the costates by a share of their step, and the multipliers as far as they stay positive and near the centre."""
    barrier, reach = interior.numbers.barrier, interior.numbers.dual
    for k in range(interior.costates.shape[0]):
        for i in range(interior.costates.shape[1]):
            interior.costates[k, i] += part * (interior.next_costates[k, i] - interior.costates[k, i])
    for k in range(interior.duals.shape[0]):
        for i in range(interior.duals.shape[1]):
            if work.flat.applies[k, i] and not work.flat.equal[i]:
                centre = barrier / interior.slacks[k, i]
                dual = interior.duals[k, i] + reach * interior.dual_steps[k, i]
                interior.duals[k, i] = min(max(dual, 1e-10 * centre), 1e10 * centre)
    rows.price_equalities(work, interior)


@kernel
def is_better(interior: Interior, infeasibility: float, merit: float, part: float) -> bool:
    """Whether the nominal trajectory is acceptable to the filter and better than (θ, φ); the filter learns of these."""
    numbers = interior.numbers
    scale, slope, first = numbers.scale, numbers.slope, max(1.0, numbers.first)
    now, cost = numbers.infeasibility, numbers.barrier_cost
    price = _MARGIN_COST * scale
    if not (now <= 1e4 * first and is_new(interior.filter, now, cost, price, -np.inf)):
        return False
    descends = slope < 0.0 and part * (-slope / scale) ** 2.3 > infeasibility**1.1
    armijo = cost <= merit + _MARGIN_COST * part * slope + 1e-10 * abs(merit)
    if descends and infeasibility <= 1e-4 * first:
        return bool(armijo)
    if not (now <= (1.0 - MARGIN) * infeasibility or cost <= merit - price * infeasibility):
        return False
    if not (descends and armijo):
        remember(interior.filter, infeasibility, merit)
    return True
