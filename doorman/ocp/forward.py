r"""Forward pass of CDDP: a rollout of the policy that stays inside the *nonlinear* constraints.

At every node the input is :math:`u = \bar u + \epsilon k + K(x - \bar x)`. Where the next state violates a constraint, Newton
corrections in the metric of Q_uu bring it back: :math:`\min_v \tfrac12 v^T Q_{uu} v` s.t. :math:`h(f(x,u)) + C B v \le 0`,
repeated until h holds. All constraints have relative degree one, so one node's input suffices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.ocp.active_set import solve_dual
from doorman.ocp.backward import DONE, fill_schur
from doorman.ocp.functions import constrain, linearize_constraints, linearize_step, step
from doorman.ocp.workspace import Workspace

Array = NDArray[np.float64]

NOT_FEASIBLE = -3
NOT_FINITE = -4

FEASIBILITY = 1e-9
"""A rollout's state violates a constraint if h exceeds this."""

_CORRECTIONS = 12
_LARGEST_STATE = 1e6


@kernel
def prepare_correction(model: object, work: Workspace, k: int) -> None:
    """Quadratic program of the correction at node k of the trial trajectory, into `work.qp` and its dual into scratch."""
    scratch, factor, trial, qp = work.scratch, work.policy.factors[k], work.trial, work.qp
    linearize_step(model, trial.states[k], trial.inputs[k], scratch.linearization)
    linearize_constraints(model, trial.states[k + 1], trial.constraints[k], scratch.constraint_jacobian)
    nh, nu, nx = len(work.sizes.constraints), len(work.sizes.inputs), len(work.sizes.states)
    for i in range(nh):
        qp.constraints[i] = trial.constraints[k, i]
        scratch.residuals[i] = trial.constraints[k, i]
        for a in range(nu):
            total = 0.0
            for m in range(nx):
                total += scratch.constraint_jacobian[i, m] * scratch.linearization[m, nx + a]
            qp.jacobian[i, a] = total
        for a in range(nu):
            total = qp.jacobian[i, a]
            for b in range(a):
                total -= factor[a, b] * scratch.projected[i, b]
            scratch.projected[i, a] = total / factor[a, a]
    fill_schur(scratch.projected, scratch.schur)
    for i in range(nu):
        qp.gradient[i] = 0.0
        for j in range(nu):
            total = 0.0
            for m in range(min(i, j) + 1):
                total += factor[i, m] * factor[j, m]
            qp.hessian[i, j] = total


@kernel
def guess_correction(work: Workspace, k: int) -> bool:
    """Solve the correction's quadratic program by guessing the active set; step into `work.qp.step`."""
    scratch, factor, qp = work.scratch, work.policy.factors[k], work.qp
    nh, nu = len(work.sizes.constraints), len(work.sizes.inputs)
    for i in range(nh):
        scratch.proposal[i] = scratch.residuals[i] > 0.0
    if not solve_dual(
        scratch.schur, scratch.residuals, scratch.proposal, scratch.indices, scratch.schur_factor, qp.multipliers
    ):
        return False
    for a in range(nu):
        total = 0.0
        for i in range(nh):
            total -= scratch.projected[i, a] * qp.multipliers[i]
        qp.step[a] = total
    for a in range(nu - 1, -1, -1):
        total = qp.step[a]
        for b in range(a + 1, nu):
            total -= factor[b, a] * qp.step[b]
        qp.step[a] = total / factor[a, a]
    return True


@kernel
def advance(model: object, work: Workspace, k: int) -> float:
    """Next state and its constraints at node k of the trial trajectory; largest constraint (inf if not finite)."""
    trial = work.trial
    step(model, trial.states[k], trial.inputs[k], trial.states[k + 1])
    for i in range(trial.states.shape[1]):
        if not abs(trial.states[k + 1, i]) < _LARGEST_STATE:
            return np.inf
    constrain(model, trial.states[k + 1], trial.constraints[k])
    worst = -np.inf
    for i in range(trial.constraints.shape[1]):
        worst = max(worst, trial.constraints[k, i])
    return worst


@kernel
def total_cost(work: Workspace) -> float:
    """J of the trial trajectory."""
    weights, states, inputs = work.weights, work.trial.states, work.trial.inputs
    n = inputs.shape[0]
    total = 0.0
    for k in range(n):
        for i in range(states.shape[1]):
            total += weights.state[i] * (states[k, i] - weights.state_goal[i]) ** 2
        for i in range(inputs.shape[1]):
            total += weights.input[i] * (inputs[k, i] - weights.input_goal[i]) ** 2
    for i in range(states.shape[1]):
        total += weights.terminal[i] * (states[n, i] - weights.state_goal[i]) ** 2
    return 0.5 * total


@kernel
def forward(model: object, work: Workspace, start: int, scale: float, guess: bool, corrections: int) -> int:
    """Roll the policy out from node `start` into the trial trajectory, whose state at `start` is set.

    Args:
        model: The problem's model.
        work: Workspace after a backward pass.
        start: Node to begin with.
        scale: ε, step length along the policy's offsets.
        guess: Try to solve corrections here; otherwise every one is left to the caller.
        corrections: Corrections that node `start` has had: if any, its input stands and `work.qp.step` is to be added.

    Returns:
        DONE (cost and violation are in `work.scratch.result`), NOT_FEASIBLE, NOT_FINITE, or the node whose correction
        (`work.qp`) the caller must solve: it then fills `work.qp.step` and calls again with `corrections` one higher.
    """
    trial, nominal, policy, qp = work.trial, work.nominal, work.policy, work.qp
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    for k in range(start, trial.inputs.shape[0]):
        done = corrections if k == start else 0
        if done == 0:
            for a in range(nu):
                total = nominal.inputs[k, a] + scale * policy.gains[k, a, nx + nu]
                for j in range(nx):
                    total += policy.gains[k, a, j] * (trial.states[k, j] - nominal.states[k, j])
                trial.inputs[k, a] = total
        else:
            for a in range(nu):
                trial.inputs[k, a] += qp.step[a]
        worst = advance(model, work, k)
        while worst > FEASIBILITY:
            if not worst < _LARGEST_STATE:
                return NOT_FINITE if done == 0 else NOT_FEASIBLE  # a correction that went astray
            if done >= _CORRECTIONS:
                return NOT_FEASIBLE
            prepare_correction(model, work, k)
            if not (guess and guess_correction(work, k)):
                return k
            for a in range(nu):
                trial.inputs[k, a] += qp.step[a]
            done += 1
            worst = advance(model, work, k)
    work.scratch.result[0] = total_cost(work)
    violation = -np.inf
    for k in range(trial.constraints.shape[0]):
        for i in range(trial.constraints.shape[1]):
            violation = max(violation, trial.constraints[k, i])
    work.scratch.result[1] = violation
    return DONE
