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
from doorman.ocp.solvers.iterations.augmented_lagrangian import direction
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
from doorman.ocp.solvers.memory.result import RESULT
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
_CHEAPER = 1e-7
"""The guess is better where it costs less by more than this, relative to 1 + |J|."""
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
    result[RESULT.SWEEPS] = 0.0
    result[RESULT.ITERATIONS] = 0.0
    if not iterate_some(model, work, iterations, iterations + extra_iterations, sweeps, deadline):
        return NO_SWEEP
    code = roll(model, work)
    if code != DONE or extra_iterations <= 0 or clock() >= deadline:
        return code
    outside = result[RESULT.LAST] == work.nominal.inputs.shape[0]
    if outside or result[RESULT.COST] > DEARER * max(cost_before, result[RESULT.EXPECTED]):
        if not iterate_some(model, work, 1, extra_iterations, sweeps, deadline):
            return NO_SWEEP
        code = roll(model, work)
    return code


@kernel
def roll(model: object, work: Workspace) -> int:
    """Rollout of what the iterations have ended with, or the kept guess where that is better."""
    result = work.result
    result[RESULT.EXPECTED] = total_cost(model, work, work.nominal)
    result[RESULT.NEAR] = 1.0
    code = int(take_rollout(model, work))
    result[RESULT.NEAR] = 0.0
    if code == DONE:
        keep_better(model, work)
    return code


@kernel
def iterate_some(model: object, work: Workspace, planned: int, most: int, all_sweeps: int, deadline: float) -> bool:
    """The planned iterations, and up to `most` where the last one changed much, with full steps.

    All of them have so many Riccati sweeps, but one of each.
    """
    result, used, penalty = work.result, work.result[RESULT.SWEEPS], work.settings.penalty
    before, slowest, first = clock(), 0.0, int(result[RESULT.ITERATIONS])
    for done in range(most):
        if done >= planned and not is_rough(model, work, done - planned):
            break
        if first + done > 0 and before + slowest + result[RESULT.ROLLOUT_TIME] > deadline:
            break
        linearize(model, work)
        if done == 0:
            keep_guess(model, work)
        sweeps = min(work.settings.sweeps, max(all_sweeps - int(result[RESULT.SWEEPS] - used), 1))
        classify(work, work.nominal, penalty)
        settled = direction(model, work, penalty, sweeps, 0.0, deadline if first + done > 0 else np.inf)
        result[RESULT.SETTLED] = settled
        if settled < 0 or not result[RESULT.CHANGE] < 1e12:
            return False
        result[RESULT.PRICE] = price(work, penalty)
        save(work)
        move(work, 1.0)
        take_multipliers(work, 1.0)
        result[RESULT.ITERATIONS] = first + done + 1.0
        now = clock()
        before, slowest = now, max(slowest, now - before)
    return True


@kernel
def keep_guess(model: object, work: Workspace) -> None:
    """Keep the nominal trajectory, after its linearisation, if it satisfies dynamics and constraints."""
    result, nx, feasibility = work.result, work.sizes.states, work.settings.feasibility
    result[RESULT.GUESS] = np.nan
    for k in range(work.nominal.inputs.shape[0]):
        for i in range(nx):
            if not abs(work.linear.jacobians[k, i, nx]) <= feasibility:
                return
    measure_nominal(work)
    if result[RESULT.VIOLATION] <= feasibility:
        copy_trajectory(work.nominal, work.guess)
        result[RESULT.GUESS] = total_cost(model, work, work.nominal)
        result[RESULT.GUESS_PRICE] = result[RESULT.INFEASIBILITY]


@kernel
def keep_better(model: object, work: Workspace) -> None:
    """Take the kept guess back if the nominal trajectory, a rollout, violates something or costs more."""
    result = work.result
    result[RESULT.ROLLED] = result[RESULT.COST] if result[RESULT.VIOLATION] <= work.settings.feasibility else np.inf
    worth = result[RESULT.GUESS] + result[RESULT.COSTATE] * result[RESULT.GUESS_PRICE]
    if worth + _CHEAPER * (1.0 + abs(worth)) < result[RESULT.ROLLED]:
        return_to_guess(model, work)


@kernel
def return_to_guess(model: object, work: Workspace) -> None:
    """Make the kept guess the nominal trajectory, with the feedback of a sweep around it."""
    copy_trajectory(work.guess, work.nominal)
    linearize(model, work)
    steer(model, work)
    measure_nominal(work)
    work.result[RESULT.COST] = work.result[RESULT.GUESS]


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
    if direction(model, work, work.settings.penalty, 1, 0.0, np.inf) < 0:
        forget_policy(work)


@kernel
def price(work: Workspace, penalty: float) -> float:
    """Worth of the multipliers' change that the step in `trial` proposes, in units of the cost."""
    trial, now, new = work.trial, work.multipliers, work.proposal
    total = 0.0
    for k in range(trial.inputs.shape[0]):
        early = 0.0
        for i in range(work.sizes.rows):
            early += (new.rows[k, i] - now.rows[k, i]) ** 2
        if work.sizes.state_bounds > 0:
            for i in range(work.sizes.states):
                early += (new.states[k, i] - now.states[k, i]) ** 2
        total += early / work.stiffness[k]
        for i in range(work.sizes.input_rows):
            total += (new.input_rows[k, i] - now.input_rows[k, i]) ** 2
        if work.sizes.input_bounds > 0:
            for i in range(work.sizes.inputs):
                total += (new.inputs[k, i] - now.inputs[k, i]) ** 2
    for i in range(work.sizes.end_rows):
        total += (new.end_rows[i] - now.end_rows[i]) ** 2
    return float(total / penalty)


@kernel
def is_rough(model: object, work: Workspace, extra: int) -> bool:
    """Whether the last iteration changed so much that another one is worth its time."""
    change = work.result[RESULT.CHANGE]
    if extra == 0 and change > _ENOUGH:
        return True
    scale = 1.0 + abs(total_cost(model, work, work.nominal))
    return bool(change * change > _FAR * scale if extra > 0 else work.result[RESULT.PRICE] > _PRICE * scale)
