r"""One node's program in a rollout: the least change of its input, in the metric of Q_uu, that restores its rows."""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.ocp.kernels.functions import (
    at_node,
    linearize_constraints,
    linearize_end_constraints,
    linearize_input_constraints,
    linearize_step,
)
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.stage_program import project_row

FEASIBILITY = 2e-7
"""A row counts as violated beyond this; corrections aim at zero [the row's unit]."""

_PASSED_OVER = -1e300
"""Value of a row that is none here: of the end before it, or an equality, which the feedback keeps."""


@kernel
def linearize_node(model: object, work: Workspace, k: int) -> None:
    """Derivatives at node k of the trial trajectory, and its rows.

    Dynamics go into `node.hessian`, rows of the next state and then of the end into `program.scratch`, mixed ones into
    `node.plain`.
    """
    nx = work.sizes.states
    nh, nt, ng = work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
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
    """Derivatives at node k from the nominal trajectory, to where `linearize_node` writes; rows stay as they are."""
    nx, nu = work.sizes.states, work.sizes.inputs
    nh, nt, ng = work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
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
    nx, nu = work.sizes.states, work.sizes.inputs
    nh, nt, ng = work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    program, trial, dynamics, slopes = work.program, work.trial, work.node.hessian, work.node.plain
    factors, rows = work.policy.factors[k], program.jacobian
    u, ahead = trial.inputs[k], trial.states[k + 1]
    if nh > 0:
        multiply_inputs(program.scratch[: nh * nx].reshape((nh, nx)), dynamics, rows, 0)
        for i in range(nh):
            program.residuals[i] = trial.rows[k, i]
    if nt > 0:
        for i in range(nh, nh + nt):
            program.residuals[i] = _PASSED_OVER
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
        if work.flat.equal[i]:
            program.residuals[i] = _PASSED_OVER
        program.constraints[i] = program.residuals[i]
        program.proposal[i] = program.residuals[i] > 0.0
        project_row(factors, rows[i], program.projected[i])


@kernel
def hopeless(work: Workspace, k: int) -> bool:
    """Whether some row of the program stays violated for every input inside its bounds: then it has no solution."""
    if work.sizes.input_bounds == 0:
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
    """Set up the program of node k."""
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
    """Product C B, with B the right part of `dynamics`."""
    nx, nu = linear.shape[1], out.shape[1]
    for i in range(linear.shape[0]):
        for a in range(nu):
            total = 0.0
            for m in range(nx):
                total += linear[i, m] * dynamics[m, nx + a]
            out[first + i, a] = total
