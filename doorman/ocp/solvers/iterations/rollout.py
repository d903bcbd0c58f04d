r"""Rollout of a policy onto the dynamics that stays inside the *nonlinear* constraints.

At every node the input is :math:`u = \bar u + \epsilon k + K(x - \bar x)`, cut off at its bounds. Where the next state, or the
input with its state, violates a row, Newton corrections in the metric of Q_uu bring it back:
:math:`\min_v \tfrac12 v^T Q_{uu} v` s.t. :math:`c + D v \le 0`, repeated until the row holds. Rows of relative degree one need
no more than their own node's input. Where the nominal trajectory's derivatives are near enough, the first correction of a node
borrows them. A node where no input is good enough is passed with the policy's own, and counted.

First the whole horizon is rolled out, and the rows are looked at all at once; only from the first violation on, if there is
one, node after node is corrected.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.ocp.kernels.functions import at_node, constrain, constrain_end, constrain_input, step
from doorman.ocp.kernels.python_functions import LARGEST_STATE
from doorman.ocp.solvers.iterations.correction import FEASIBILITY, set_up
from doorman.ocp.solvers.iterations.nominal import evaluate_rows, measure, total_cost
from doorman.ocp.solvers.memory.workspace import Workspace, copy_trajectory
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
def largest(values: Array, floors: Array) -> float:
    """Largest value of the rows that are no equalities: those the feedback keeps."""
    worst = -np.inf
    for i in range(values.shape[0]):
        if floors[i] == 0.0:
            worst = max(worst, values[i])
    return worst


@kernel
def worst_row(model: object, work: Workspace, k: int, evaluate: bool) -> float:
    """Largest value of a row or state bound at node k of the trial trajectory."""
    floors, trial, last = work.floors, work.trial, k == work.trial.inputs.shape[0] - 1
    if evaluate:
        if work.sizes.rows > 0:
            constrain(at_node(model, k + 1), trial.states[k + 1], trial.rows[k])
        if work.sizes.input_rows > 0:
            constrain_input(at_node(model, k), trial.states[k], trial.inputs[k], trial.input_rows[k])
        if last and work.sizes.end_rows > 0:
            constrain_end(at_node(model, k + 1), trial.states[k + 1], trial.end_rows)
    worst = max(largest(trial.rows[k], floors.rows), largest(trial.input_rows[k], floors.input_rows))
    if last:
        worst = max(worst, largest(trial.end_rows, floors.end_rows))
    if work.sizes.state_bounds > 0:
        x, limits = trial.states[k + 1], work.limits
        for i in range(work.sizes.states):
            worst = max(worst, x[i] - limits.state_upper[i], limits.state_lower[i] - x[i])
    return float(worst)


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
        work.result.relaxed = 0
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
                if set_up(model, work, k, done > 0 or not work.result.near):
                    apply_policy(work.tiles, k, work, scale)
                    done = -1
                elif work.settings.guess_active_sets == 0 or not solve_dual(work, k):
                    export_program(work, k, False)
                    work.result.corrections = done
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
            work.result.relaxed += 1
    work.result.cost = total_cost(model, work, work.trial)
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
    work.result.rollout_time = clock() - begun
    return code
