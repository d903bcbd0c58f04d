r"""Rollout of a policy onto the dynamics that stays inside the *nonlinear* constraints.

At every node the input is :math:`u = \bar u + \epsilon k + K(x - \bar x)`, cut off at its bounds. Where the next state, or the
input with its state, violates a row, Newton corrections in the metric of Q_uu bring it back:
:math:`\min_v \tfrac12 v^T Q_{uu} v` s.t. :math:`c + D v \le 0`, repeated until the row holds. Rows of relative degree one need
no more than their own node's input. Where the nominal trajectory's derivatives are near enough (`NEAR`), the first correction of
a node borrows them. A node where no input is good enough is passed with the policy's own, and counted.

First the whole horizon is rolled out, and the rows are looked at all at once; only from the first violation on, if there is
one, node after node is corrected.
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.ocp.kernels.functions import at_node, constrain, constrain_end, constrain_input, step
from doorman.ocp.solvers.iterations.correction import FEASIBILITY, set_up
from doorman.ocp.solvers.iterations.nominal import evaluate_rows, measure, total_cost
from doorman.ocp.solvers.memory.result import RESULT
from doorman.ocp.solvers.memory.workspace import LARGEST_STATE, Workspace, copy_trajectory
from doorman.ocp.solvers.sweeps.sized import apply_policy
from doorman.ocp.solvers.sweeps.stage_program import export_program, solve_dual, substitute_step

DONE = -1
NOT_FINITE = -4

_CORRECTIONS = 12


@kernel
def advance(model: object, work: Workspace, k: int) -> bool:
    """Next state of the trial trajectory."""
    trial = work.trial
    step(at_node(model, k), trial.states[k], trial.inputs[k], trial.states[k + 1])
    for i in range(trial.states.shape[1]):
        if not abs(trial.states[k + 1, i]) < LARGEST_STATE:
            return False
    return True


@kernel
def worst_row(model: object, work: Workspace, k: int, evaluate: bool) -> float:
    """Largest value of a row or state bound at node k of the trial trajectory.

    Equalities do not count: the feedback keeps them.
    """
    floors, equal = work.floors, work.sizes.equalities > 0
    trial, nx, last = work.trial, work.sizes.states, k == work.trial.inputs.shape[0] - 1
    if evaluate:
        if work.sizes.rows > 0:
            constrain(at_node(model, k + 1), trial.states[k + 1], trial.rows[k])
        if work.sizes.input_rows > 0:
            constrain_input(at_node(model, k), trial.states[k], trial.inputs[k], trial.input_rows[k])
        if last and work.sizes.end_rows > 0:
            constrain_end(at_node(model, k + 1), trial.states[k + 1], trial.end_rows)
    worst = -np.inf
    for i in range(work.sizes.rows):
        if not equal or floors.rows[i] == 0.0:
            worst = max(worst, trial.rows[k, i])
    for i in range(work.sizes.input_rows):
        if not equal or floors.input_rows[i] == 0.0:
            worst = max(worst, trial.input_rows[k, i])
    if last:
        for i in range(work.sizes.end_rows):
            if not equal or floors.end_rows[i] == 0.0:
                worst = max(worst, trial.end_rows[i])
    if work.sizes.state_bounds > 0:
        x, limits = trial.states[k + 1], work.limits
        for i in range(nx):
            worst = max(worst, x[i] - limits.state_upper[i], limits.state_lower[i] - x[i])
    return worst


@kernel
def correct(work: Workspace, k: int) -> None:
    """Add `program.step` to input k of the trial trajectory, inside its bounds."""
    for a in range(work.sizes.inputs):
        value = work.trial.inputs[k, a] + work.program.step[a]
        if work.sizes.input_bounds > 0:
            value = min(max(value, work.limits.input_lower[a]), work.limits.input_upper[a])
        work.trial.inputs[k, a] = value


@kernel
def roll_freely(model: object, work: Workspace, scale: float) -> int:
    """Roll out without corrections."""
    n = work.trial.inputs.shape[0]
    for k in range(n):
        apply_policy(work.tiles, k, work, scale)
        if not advance(model, work, k):
            return NOT_FINITE
    evaluate_rows(model, work, work.trial)
    for k in range(n):
        if worst_row(model, work, k, False) > FEASIBILITY:
            return k
    return DONE


@kernel
def roll_out(model: object, work: Workspace, start: int, scale: float, corrections: int) -> int:
    """Roll the policy out into the trial trajectory, whose first state is set."""
    n, first = work.trial.inputs.shape[0], start
    if start < 0:
        work.result[RESULT.RELAXED] = 0.0
        first = roll_freely(model, work, scale)
        if first == NOT_FINITE:
            first = 0  # the way there leads through what the corrections avoid
        if first == DONE:
            first = n
    for k in range(first, n):
        done = corrections if k == start else 0
        if done <= 0:
            apply_policy(work.tiles, k, work, scale)
        else:
            correct(work, k)
        if not advance(model, work, k):
            return NOT_FINITE
        worst = worst_row(model, work, k, True)
        for _ in range(_CORRECTIONS + 1):
            if not (worst > FEASIBILITY and done >= 0):
                break
            if done < _CORRECTIONS:
                if set_up(model, work, k, done > 0 or work.result[RESULT.NEAR] == 0.0):
                    apply_policy(work.tiles, k, work, scale)
                    done = -1
                elif work.settings.guess_active_sets == 0 or not solve_dual(work, k):
                    export_program(work, k, False)
                    work.result[RESULT.CORRECTIONS] = done
                    return k
                else:
                    substitute_step(work, k)
                    correct(work, k)
                    done += 1
            else:
                apply_policy(work.tiles, k, work, scale)
                done = -1
            if not advance(model, work, k):
                apply_policy(work.tiles, k, work, scale)
                done = -1
                if not advance(model, work, k):
                    return NOT_FINITE
            worst = worst_row(model, work, k, True)
        if done < 0:
            work.result[RESULT.RELAXED] += 1.0
    work.result[RESULT.COST] = total_cost(model, work, work.trial)
    measure(work, work.trial)
    return DONE


@kernel
def take_rollout(model: object, work: Workspace) -> int:
    """Roll the nominal trajectory out; a rollout that comes to its end is the nominal trajectory from then on."""
    begun = clock()
    work.trial.states[0, :] = work.nominal.states[0]
    code = int(roll_out(model, work, -1, 0.0, 0))
    if code == DONE:
        copy_trajectory(work.trial, work.nominal)
    work.result[RESULT.ROLLOUT_TIME] = clock() - begun
    return code
