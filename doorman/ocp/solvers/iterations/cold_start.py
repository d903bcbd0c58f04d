"""A solve from nothing: a first guess, fast iterations, and the rollout of what they end with, in one call.

One call and not five: after an iteration whatever stands around it has left the caches, and takes three times as long.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.kernels.functions import at_node, constrain, step
from doorman.ocp.solvers.iterations.augmented_lagrangian import CONVERGED, PAUSED, iterate
from doorman.ocp.solvers.iterations.guess import aim_straight, roll_blindly, settle_integrators
from doorman.ocp.solvers.iterations.nominal import total_cost
from doorman.ocp.solvers.iterations.rollout import take_rollout
from doorman.ocp.solvers.memory.workspace import Workspace, copy_trajectory
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows

INVALID_START = -5
NOT_CONVERGED = -6
TO_RESUME = -7

_ASTRAY = 2.25
"""A blind rollout that costs so many times the straight line is no good start; found by measurement on the door problem."""


@kernel
def solve(
    model: object,
    work: Workspace,
    state: Array,
    inputs: bool,
    states: bool,
    multipliers: bool,
    max_iterations: int,
    deadline: float,
) -> int:
    """Begin, iterate, and where that converges roll out into the nominal trajectory."""
    if not work.result.resumes:
        if not begin(model, work, state, inputs, states, multipliers):
            return INVALID_START
        if not (inputs or states):
            choose_guess(model, work)
    code = iterate(model, work, max_iterations, deadline - work.result.rollout_time)
    if code != CONVERGED:
        return TO_RESUME if code == PAUSED else NOT_CONVERGED
    work.result.expected = total_cost(model, work, work.nominal)
    return int(take_rollout(model, work))


@kernel
def begin(model: object, work: Workspace, state: Array, inputs: bool, states: bool, multipliers: bool) -> bool:
    """Start anew from what is given in the nominal trajectory and the multipliers: no feedback, nothing rolled out."""
    nominal, limits = work.nominal, work.limits
    for k in range(nominal.inputs.shape[0]):
        for i in range(0 if inputs else work.sizes.inputs):
            nominal.inputs[k, i] = work.weights.input_goal[i]
        if work.sizes.input_bounds > 0:
            for i in range(work.sizes.inputs):
                nominal.inputs[k, i] = min(max(nominal.inputs[k, i], limits.input_lower[i]), limits.input_upper[i])
    if not multipliers:
        forget_multipliers(work)
    forget_policy(work)
    for i in range(state.shape[0]):
        nominal.states[0, i] = state[i]
    if states:
        settle_integrators(work)
    else:
        roll_blindly(model, work, 0)
    finite = starts_finite(model, work)
    forget_trial(work)
    copy_rows(nominal.states, work.first.states)
    copy_rows(nominal.inputs, work.first.inputs)
    if np.isnan(work.result.guess):
        copy_trajectory(nominal, work.guess)
        work.result.guess = total_cost(model, work, nominal)
    return finite


@kernel
def choose_guess(model: object, work: Workspace) -> None:
    """Keep the blind rollout, or take the straight line where the rollout costs far more.

    A long blind rollout goes astray; a short one satisfies the dynamics, which is worth more than its cost.
    """
    blind = total_cost(model, work, work.nominal)
    aim_straight(work)
    if blind <= _ASTRAY * total_cost(model, work, work.nominal):
        copy_rows(work.first.states, work.nominal.states)
        copy_rows(work.first.inputs, work.nominal.inputs)


@kernel
def forget_policy(work: Workspace) -> None:
    """Set the feedback to zero, and the weights of inputs to those of the cost."""
    policy = work.policy
    policy.gains[:, :, :] = 0.0
    policy.factors[:, :, :] = 0.0
    for k in range(policy.factors.shape[0]):
        for i in range(work.sizes.inputs):
            policy.factors[k, i, i] = work.weights.metric[i]


@kernel
def starts_finite(model: object, work: Workspace) -> bool:
    """Whether dynamics and constraints are finite at the start of the nominal trajectory; overwrites the trial one."""
    state, ahead, rows = work.nominal.states[0], work.trial.states[1], work.trial.rows[0]
    step(at_node(model, 0), state, work.nominal.inputs[0], ahead)
    total = 0.0
    for i in range(ahead.shape[0]):
        total += abs(ahead[i])
    if work.sizes.rows > 0:
        constrain(at_node(model, 0), state, rows)
        for i in range(rows.shape[0]):
            total += abs(rows[i])
    return bool(total < np.inf)


@kernel
def forget_multipliers(work: Workspace) -> None:
    """Set all multipliers to zero."""
    kept = work.multipliers
    kept.rows[:, :] = 0.0
    kept.input_rows[:, :] = 0.0
    kept.end_rows[:] = 0.0
    kept.states[:, :] = 0.0
    kept.inputs[:, :] = 0.0


@kernel
def forget_trial(work: Workspace) -> None:
    """Fill the trial trajectory with NaN after its start: a failed rollout must not be taken for a result."""
    trial = work.trial
    trial.states[:, :] = np.nan
    trial.inputs[:, :] = np.nan
    trial.rows[:, :] = np.nan
    trial.input_rows[:, :] = np.nan
    trial.end_rows[:] = np.nan
    trial.states[0, :] = work.nominal.states[0]
