r"""Real-time iteration: shift the last trajectory, bend it to where the state is, iterate, roll out, in one call.

The work is bounded: most replans take one iteration, and one more where the last step was large. What is left of the
suboptimality is, to first order, the price of the multipliers' last change,

.. math:: \sum_i |\lambda_i^+ - \lambda_i|\,|r_i| = \tfrac1\mu\sum_{i\ \mathrm{active}} r_i^2

with the linearised rows r: they must be zero where the multipliers do not move any more. Where it is large, as where noise
throws the first states onto a constraint, one more iteration follows; a third one changes little but where the second went far.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.ocp.solvers.iterations import guess
from doorman.ocp.solvers.iterations.augmented_lagrangian import ACCURACY, direction
from doorman.ocp.solvers.iterations.cold_start import forget_policy
from doorman.ocp.solvers.iterations.nominal import (
    linearize,
    measure_nominal,
    move,
    save,
    take_multipliers,
    total_cost,
)
from doorman.ocp.solvers.iterations.rollout import DONE, take_rollout
from doorman.ocp.solvers.memory.workspace import Workspace, copy_trajectory
from doorman.ocp.solvers.sweeps.active_set import classify
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows

NO_SWEEP = -9
"""No Riccati sweep went through."""

KEEP_BETTER, RETURN, STEER = 0, 1, 2
"""Modes of `settle`."""

DEARER = 1.2
"""A rollout that costs so many times what the one before did, and what its iteration expected, may come of a trajectory that is
no guess. Noise alone makes a start dearer by as much; the iteration then expects it."""

_ENOUGH = 0.005
"""An iteration that changes an input by more, weighted by its cost, is followed by another one."""
_PRICE = 1e-6
"""One whose change of the multipliers costs more is, too, relative to 1 + |J|."""
_FAR = 1e-5
"""A third one follows where the second changed an input's cost by more, relative to 1 + |J|."""


@kernel
def follow(
    model: object,
    work: Workspace,
    state: Array,
    shift: float,
    limit: int,
    iterations: int,
    extra_iterations: int,
    sweeps: int,
    deadline: float,
    cost_before: float,
) -> int:
    """Shift, iterate and roll out; a rollout that comes to its end is the nominal trajectory from then on.

    A guess that satisfies everything comes back itself where the rollout is worse, see `keep_better`. A rollout that ends
    outside, or costs far more than expected, is followed once more. The trajectory before stays in `work.first`.
    """
    result = work.result
    copy_rows(work.nominal.states, work.first.states)
    copy_rows(work.nominal.inputs, work.first.inputs)
    guess.shift_guess(model, work, state, shift, limit)
    result.sweeps, result.iterations = 0, 0
    if not iterate_some(model, work, iterations, iterations + extra_iterations, sweeps, deadline):
        return NO_SWEEP
    code = roll(model, work)
    if code != DONE or extra_iterations <= 0 or clock() >= deadline:
        return code
    outside = result.last_violated == work.nominal.inputs.shape[0]
    if outside or result.cost > DEARER * max(cost_before, result.expected):
        if not iterate_some(model, work, 1, extra_iterations, sweeps, deadline):
            return NO_SWEEP
        code = roll(model, work)
    return code


@kernel
def roll(model: object, work: Workspace) -> int:
    """Rollout of what the iterations have ended with, or the kept guess where that is better."""
    result = work.result
    result.expected = total_cost(model, work, work.nominal)
    result.near = True
    code = int(take_rollout(model, work))
    result.near = False
    if code == DONE:
        keep_better(model, work)
    return code


@kernel
def iterate_some(model: object, work: Workspace, planned: int, most: int, all_sweeps: int, deadline: float) -> bool:
    """The planned iterations, and up to `most` where the last one changed much, with full steps.

    All of them have so many Riccati sweeps, but one of each.
    """
    result, used, penalty = work.result, work.result.sweeps, work.settings.penalty
    before, slowest, first = clock(), 0.0, result.iterations
    for done in range(most):
        if done >= planned and not is_rough(model, work, done - planned):
            break
        if first + done > 0 and before + slowest + result.rollout_time > deadline:
            break
        linearize(model, work)
        if done == 0:
            keep_guess(model, work)
        sweeps = min(work.settings.sweeps, max(all_sweeps + used - result.sweeps, 1))
        classify(work, work.nominal, penalty)
        if not direction(model, work, penalty, sweeps, 0.0, deadline if first + done > 0 else np.inf):
            return False
        if not result.change < 1e12:
            return False
        result.price = price(work, penalty)
        save(work)
        move(work, 1.0)
        take_multipliers(work, 1.0)
        result.iterations = first + done + 1
        now = clock()
        before, slowest = now, max(slowest, now - before)
    return True


@kernel
def keep_guess(model: object, work: Workspace) -> None:
    """Keep the nominal trajectory, after its linearisation, if it satisfies dynamics and constraints."""
    result, nx, feasibility = work.result, work.sizes.states, work.settings.feasibility
    result.guess = np.nan
    for k in range(work.nominal.inputs.shape[0]):
        for i in range(nx):
            if not abs(work.linear.jacobians[k, i, nx]) <= feasibility:
                return
    measure_nominal(work)
    if result.violation <= feasibility:
        copy_trajectory(work.nominal, work.guess)
        result.guess = total_cost(model, work, work.nominal)
        result.guess_price = result.infeasibility


@kernel
def keep_better(model: object, work: Workspace) -> None:
    """Take the kept guess back if the nominal trajectory, a rollout, violates something or costs more."""
    result = work.result
    result.rolled = result.cost if result.violation <= work.settings.feasibility else np.inf
    worth = result.guess + result.costate * result.guess_price
    if worth + ACCURACY * (1.0 + abs(worth)) < result.rolled:
        return_to_guess(model, work)


@kernel
def return_to_guess(model: object, work: Workspace) -> None:
    """Make the kept guess the nominal trajectory, with the feedback of a sweep around it."""
    copy_trajectory(work.guess, work.nominal)
    linearize(model, work)
    steer(model, work)
    measure_nominal(work)
    work.result.cost = work.result.guess


@kernel
def settle(model: object, work: Workspace, how: int) -> None:
    """`keep_better`, `return_to_guess` or `steer`, for Python: each needs a sweep, of which an entry has its own copy."""
    if how == KEEP_BETTER:
        keep_better(model, work)
    elif how == RETURN:
        return_to_guess(model, work)
    else:
        steer(model, work)


@kernel
def steer(model: object, work: Workspace) -> None:
    """Feedback around the nominal trajectory, after its linearisation; none where no sweep goes through."""
    classify(work, work.nominal, work.settings.penalty)
    if not direction(model, work, work.settings.penalty, 1, 0.0, np.inf):
        forget_policy(work)


@kernel
def price(work: Workspace, penalty: float) -> float:
    """Worth of the multipliers' change that the step in `trial` proposes, in units of the cost."""
    now, new, total = work.multipliers, work.proposal, 0.0
    for k in range(work.nominal.inputs.shape[0]):
        total += (square_gap(now.rows[k], new.rows[k]) + square_gap(now.states[k], new.states[k])) / work.stiffness[k]
        total += square_gap(now.input_rows[k], new.input_rows[k]) + square_gap(now.inputs[k], new.inputs[k])
    return float((total + square_gap(now.end_rows, new.end_rows)) / penalty)


@kernel
def square_gap(one: Array, other: Array) -> float:
    """Square of the distance of two vectors."""
    total = 0.0
    for i in range(one.shape[0]):
        total += (other[i] - one[i]) ** 2
    return total


@kernel
def is_rough(model: object, work: Workspace, extra: int) -> bool:
    """Whether the last iteration changed so much that another one is worth its time."""
    change = work.result.change
    if extra == 0 and change > _ENOUGH:
        return True
    scale = 1.0 + abs(total_cost(model, work, work.nominal))
    return bool(change * change > _FAR * scale if extra > 0 else work.result.price > _PRICE * scale)
