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
from doorman.numba_types.lanes import clock
from doorman.ocp.kernels.functions import (
    at_node,
    constrain,
    constrain_end,
    constrain_horizon,
    constrain_input,
    linearize_constraints,
    linearize_end_constraints,
    linearize_input_constraints,
    linearize_step,
    step,
)
from doorman.ocp.solvers.iterations.augmented_lagrangian import measure, total_cost
from doorman.ocp.solvers.iterations.guess import accept_trial, start_trial
from doorman.ocp.solvers.sweeps.stage_program import export_program, project_row, solve_dual, substitute_step
from doorman.ocp.solvers.workspace import LARGEST_STATE, RESULT, Workspace

DONE = -1
NOT_FINITE = -4

FEASIBILITY = 2e-7
"""A row counts as violated beyond this; corrections aim at zero [the row's unit]."""

_CORRECTIONS = 12


@kernel
def apply_policy(work: Workspace, k: int, scale: float) -> None:
    """Input of node k of the trial trajectory by the policy, inside its bounds."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    nominal, trial, gains, limits = work.nominal, work.trial, work.policy.gains, work.limits
    for a in range(nu):
        total = nominal.inputs[k, a] + scale * gains[k, a, nx]
        for j in range(nx):
            total += gains[k, a, j] * (trial.states[k, j] - nominal.states[k, j])
        if len(work.sizes.input_bounds) > 0:
            total = min(max(total, limits.input_lower[a]), limits.input_upper[a])
        trial.inputs[k, a] = total


@kernel
def advance(model: object, work: Workspace, k: int) -> bool:
    """Next state of the trial trajectory; False if it is not finite."""
    trial = work.trial
    step(at_node(model, k), trial.states[k], trial.inputs[k], trial.states[k + 1])
    for i in range(trial.states.shape[1]):
        if not abs(trial.states[k + 1, i]) < LARGEST_STATE:
            return False
    return True


@kernel
def worst_row(model: object, work: Workspace, k: int, evaluate: bool) -> float:
    """Largest row or state bound at node k of the trial trajectory, after its rows are evaluated if asked for."""
    trial, nx, last = work.trial, len(work.sizes.states), k == work.trial.inputs.shape[0] - 1
    if evaluate:
        if len(work.sizes.rows) > 0:
            constrain(at_node(model, k + 1), trial.states[k + 1], trial.rows[k])
        if len(work.sizes.input_rows) > 0:
            constrain_input(at_node(model, k), trial.states[k], trial.inputs[k], trial.input_rows[k])
        if last and len(work.sizes.end_rows) > 0:
            constrain_end(at_node(model, k + 1), trial.states[k + 1], trial.end_rows)
    worst = -np.inf
    for i in range(len(work.sizes.rows)):
        worst = max(worst, trial.rows[k, i])
    for i in range(len(work.sizes.input_rows)):
        worst = max(worst, trial.input_rows[k, i])
    if last:
        for i in range(len(work.sizes.end_rows)):
            worst = max(worst, trial.end_rows[i])
    if len(work.sizes.state_bounds) > 0:
        x, limits = trial.states[k + 1], work.limits
        for i in range(nx):
            worst = max(worst, x[i] - limits.state_upper[i], limits.state_lower[i] - x[i])
    return worst


@kernel
def linearize_node(model: object, work: Workspace, k: int) -> None:
    """Derivatives at node k of the trial trajectory, and its rows.

    Dynamics go into `node.hessian`, rows of the next state and then of the end into `program.scratch`, mixed ones into
    `node.plain`.
    """
    nx = len(work.sizes.states)
    nh, nt, ng = len(work.sizes.rows), len(work.sizes.end_rows), len(work.sizes.input_rows)
    program, trial = work.program, work.trial
    x, u, ahead = trial.states[k], trial.inputs[k], trial.states[k + 1]
    linearize_step(at_node(model, k), x, u, work.node.hessian[:nx])
    if nh > 0:
        linearize_constraints(at_node(model, k + 1), ahead, trial.rows[k], program.scratch[: nh * nx].reshape((nh, nx)))
    if nt > 0 and k == trial.inputs.shape[0] - 1:
        slopes = program.scratch[nh * nx : (nh + nt) * nx].reshape((nt, nx))
        linearize_end_constraints(at_node(model, k + 1), ahead, trial.end_rows, slopes)
    if ng > 0:
        linearize_input_constraints(at_node(model, k), x, u, trial.input_rows[k], work.node.plain[:ng])


@kernel
def borrow_linearization(work: Workspace, k: int) -> None:
    """The same derivatives from the nominal trajectory; rows stay as they are."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    nh, nt, ng = len(work.sizes.rows), len(work.sizes.end_rows), len(work.sizes.input_rows)
    program, linear, dynamics = work.program, work.linear, work.node.hessian
    for i in range(nx):
        for a in range(nu):
            dynamics[i, nx + a] = linear.jacobians[k, i, nx + 1 + a]
    for i in range(nh):
        for j in range(nx):
            program.scratch[i * nx + j] = linear.row_jacobians[k, i, j]
    for i in range(nt if k == work.trial.inputs.shape[0] - 1 else 0):
        for j in range(nx):
            program.scratch[(nh + i) * nx + j] = linear.end_row_jacobians[i, j]
    for i in range(ng):
        for a in range(nu):
            work.node.plain[i, nx + a] = linear.input_row_jacobians[k, i, nx + 1 + a]


@kernel
def fill_program(work: Workspace, k: int) -> None:
    """Program of the correction at node k of the trial trajectory, from its rows and derivatives."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    nh, nt, ng = len(work.sizes.rows), len(work.sizes.end_rows), len(work.sizes.input_rows)
    program, trial, dynamics, slopes = work.program, work.trial, work.node.hessian, work.node.plain
    factors, rows = work.policy.factors[k], program.jacobian
    u, ahead = trial.inputs[k], trial.states[k + 1]
    if nh > 0:
        multiply_inputs(program.scratch[: nh * nx].reshape((nh, nx)), dynamics, rows, 0)
        for i in range(nh):
            program.residuals[i] = trial.rows[k, i]
    if nt > 0:
        for i in range(nh, nh + nt):
            program.residuals[i] = -1e300
            for a in range(nu):
                rows[i, a] = 0.0
        if k == trial.inputs.shape[0] - 1:
            multiply_inputs(program.scratch[nh * nx : (nh + nt) * nx].reshape((nt, nx)), dynamics, rows, nh)
            for i in range(nt):
                program.residuals[nh + i] = trial.end_rows[i]
    for i in range(ng):
        program.residuals[nh + nt + i] = trial.input_rows[k, i]
        for a in range(nu):
            rows[nh + nt + i, a] = slopes[i, nx + a]
    for i in range(program.bounded.shape[0]):
        index, side, row = program.bounded[i], program.side[i], nh + nt + ng + i
        value = ahead[index] if index < nx else u[index - nx]
        program.residuals[row] = side * (value - program.limit[i])
        for a in range(nu):
            if index < nx:
                rows[row, a] = side * dynamics[index, nx + a]
            else:
                rows[row, a] = side if a == index - nx else 0.0
    for i in range(rows.shape[0]):
        program.constraints[i] = program.residuals[i]
        program.proposal[i] = program.residuals[i] > 0.0
        project_row(factors, rows[i], program.projected[i])


@kernel
def hopeless(work: Workspace, k: int) -> bool:
    """Whether some row of the program stays violated for every input inside its bounds: a sign that it has no solution."""
    if len(work.sizes.input_bounds) == 0:
        return False
    program, limits, u = work.program, work.limits, work.trial.inputs[k]
    for i in range(program.constraints.shape[0]):
        least = program.constraints[i]
        if least > FEASIBILITY:
            for a in range(u.shape[0]):
                slope = program.jacobian[i, a]
                if slope != 0.0:
                    least += min(slope * (limits.input_lower[a] - u[a]), slope * (limits.input_upper[a] - u[a]))
            if least > FEASIBILITY:
                return True
    return False


@kernel
def set_up(model: object, work: Workspace, k: int, exact: bool) -> bool:
    """Set the program of node k up, with derivatives of its own or of the nominal trajectory; whether it is hopeless."""
    if not exact:
        borrow_linearization(work, k)
        fill_program(work, k)
        if not hopeless(work, k):
            return False
    linearize_node(model, work, k)
    fill_program(work, k)
    return hopeless(work, k)


@kernel
def multiply_inputs(linear: np.ndarray, dynamics: np.ndarray, out: np.ndarray, first: int) -> None:
    """Rows C B from row `first` on, with B the right part of `dynamics`."""
    nx, nu = linear.shape[1], out.shape[1]
    for i in range(linear.shape[0]):
        for a in range(nu):
            total = 0.0
            for m in range(nx):
                total += linear[i, m] * dynamics[m, nx + a]
            out[first + i, a] = total


@kernel
def correct(work: Workspace, k: int) -> None:
    """Add `program.step` to input k of the trial trajectory, inside its bounds."""
    for a in range(len(work.sizes.inputs)):
        value = work.trial.inputs[k, a] + work.program.step[a]
        if len(work.sizes.input_bounds) > 0:
            value = min(max(value, work.limits.input_lower[a]), work.limits.input_upper[a])
        work.trial.inputs[k, a] = value


@kernel
def roll_freely(model: object, work: Workspace, scale: float) -> int:
    """Roll out without corrections; the first node that violates a row, DONE, or NOT_FINITE."""
    trial, n = work.trial, work.trial.inputs.shape[0]
    for k in range(n):
        apply_policy(work, k, scale)
        if not advance(model, work, k):
            return NOT_FINITE
    if len(work.sizes.rows) > 0:
        constrain_horizon(model, trial.states, trial.rows)
    if len(work.sizes.input_rows) > 0:
        for k in range(n):
            constrain_input(at_node(model, k), trial.states[k], trial.inputs[k], trial.input_rows[k])
    if len(work.sizes.end_rows) > 0:
        constrain_end(at_node(model, n), trial.states[n], trial.end_rows)
    for k in range(n):
        if worst_row(model, work, k, False) > FEASIBILITY:
            return k
    return DONE


@kernel
def roll_out(model: object, work: Workspace, start: int, scale: float, guess: bool, corrections: int) -> int:
    """Roll the policy out into the trial trajectory, whose first state is set.

    Args:
        model: The problem's model.
        work: Workspace after a sweep.
        start: Node to begin with: −1 for all of it, without corrections as far as none are needed.
        scale: ε, step length along the policy's offsets.
        guess: Try to solve corrections here; otherwise every one is left to the caller.
        corrections: Corrections that node `start` has had: if any, its input stands and `program.step` is to be added; −1 if
            it has no solution, and the policy's own input is to stand.

    Returns:
        DONE (cost and violation are in `result`), NOT_FINITE, or the node whose correction (`program`) the caller must solve:
        it then fills `program.step` and calls again with `corrections` one higher, or −1.
    """
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
            apply_policy(work, k, scale)
        else:
            correct(work, k)
        if not advance(model, work, k):
            return NOT_FINITE
        worst = worst_row(model, work, k, True)
        while worst > FEASIBILITY and done >= 0:
            if done < _CORRECTIONS:
                if set_up(model, work, k, done > 0 or work.result[RESULT.NEAR] == 0.0):
                    apply_policy(work, k, scale)
                    done = -1
                elif not (guess and solve_dual(work, k)):
                    export_program(work, k, False)
                    work.result[RESULT.CORRECTIONS] = done
                    return k
                else:
                    substitute_step(work, k)
                    correct(work, k)
                    done += 1
            else:
                apply_policy(work, k, scale)
                done = -1
            if not advance(model, work, k):
                apply_policy(work, k, scale)
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
def take_rollout(model: object, work: Workspace, guessing: bool) -> int:
    """Roll the nominal trajectory out; a rollout that comes to its end is the nominal trajectory from then on.

    Args:
        model: The problem's model.
        work: Workspace after a sweep.
        guessing: See `roll_out`.

    Returns:
        The code of `roll_out`.
    """
    begun = clock()
    start_trial(work)
    code = int(roll_out(model, work, -1, 0.0, guessing, 0))
    if code == DONE:
        accept_trial(work)
    work.result[RESULT.ROLLOUT_TIME] = clock() - begun
    return code
