"""The nominal trajectory: derivatives along it, its cost, what it violates, and a step from it."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.kernels.functions import (
    at_node,
    constrain_end,
    constrain_horizon,
    constrain_input,
    end_cost,
    linearize_end_constraints,
    linearize_horizon,
    linearize_input_constraints,
    stage_cost,
)
from doorman.ocp.solvers.memory.parts import Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.full_weights import off_diagonal_slope
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows, go_between
from doorman.ocp.solvers.sweeps.sized import diagonal_cost


@kernel
def linearize(model: object, work: Workspace) -> None:
    """Linearise dynamics with defects, and all rows, along the nominal trajectory."""
    nx, nu = work.sizes.states, work.sizes.inputs
    nominal, linear, plain = work.nominal, work.linear, work.node.plain
    linearize_horizon(model, nominal.states, nominal.inputs, linear.jacobians, nominal.rows, linear.row_jacobians)
    ng, nt, n = work.sizes.input_rows, work.sizes.end_rows, nominal.inputs.shape[0]
    if ng > 0:
        for k in range(n):
            linearize_input_constraints(
                at_node(model, k), nominal.states[k], nominal.inputs[k], nominal.input_rows[k], plain[:ng]
            )
            for i in range(ng):
                for j in range(nx):
                    linear.input_row_jacobians[k, i, j] = plain[i, j]
                for j in range(nu):
                    linear.input_row_jacobians[k, i, nx + 1 + j] = plain[i, nx + j]
    if nt > 0:
        slopes = work.program.scratch[: nt * nx].reshape((nt, nx))
        linearize_end_constraints(at_node(model, n), nominal.states[n], nominal.end_rows, slopes)
        for i in range(nt):
            for j in range(nx):
                linear.end_row_jacobians[i, j] = slopes[i, j]


@kernel
def evaluate_rows(model: object, work: Workspace, at: Trajectory) -> None:
    """Values of all rows along a trajectory."""
    n = at.inputs.shape[0]
    if work.sizes.rows > 0:
        constrain_horizon(model, at.states, at.rows)
    if work.sizes.input_rows > 0:
        for k in range(n):
            constrain_input(at_node(model, k), at.states[k], at.inputs[k], at.input_rows[k])
    if work.sizes.end_rows > 0:
        constrain_end(at_node(model, n), at.states[n], at.end_rows)


@kernel
def total_cost(model: object, work: Workspace, trajectory: Trajectory) -> float:
    """Cost J of a trajectory."""
    states, inputs, n = trajectory.states, trajectory.inputs, trajectory.inputs.shape[0]
    total = diagonal_cost(work.tiles, 0, work, states, inputs)
    if work.sizes.full_cost > 0:
        for k in range(n + 1):
            total += off_diagonal_slope(work, trajectory, k, work.node.gradient)
    if work.sizes.extra_cost > 0:
        for k in range(n):
            total += stage_cost(at_node(model, k), states[k], inputs[k])
        total += end_cost(at_node(model, n), states[n])
    return float(total)


@kernel
def nominal_cost(model: object, work: Workspace) -> float:
    """Cost J of the nominal trajectory."""
    return total_cost(model, work, work.nominal)


@kernel
def violation(work: Workspace, value: float, floor: float) -> float:
    """Violation of a row: its value, or the magnitude of it for an equality; a value that is not positive is no violation."""
    return abs(value) if work.sizes.equalities > 0 and floor < 0.0 else value


@kernel
def count(work: Workspace, value: float, node: int, row: int) -> None:
    """Count what a row violates, and note where the worst and the last violation are."""
    result = work.result
    if not abs(value) < np.inf:
        result.infeasibility = np.inf
    elif value > 0.0:
        result.infeasibility += value
    if not value <= work.settings.feasibility:
        result.last_violated = max(result.last_violated, node)
    if value > result.violation:
        result.violation, result.node, result.row = value, node, row


@kernel
def measure(work: Workspace, trajectory: Trajectory) -> None:
    """Largest violation of a trajectory, its node and row, and the sum of violations, into `result`."""
    result, floors, program = work.result, work.floors, work.program
    nx, n = work.sizes.states, trajectory.inputs.shape[0]
    nh, nt, ng = work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    result.defect, result.violation, result.infeasibility = 0.0, 0.0, 0.0
    result.node, result.row, result.last_violated = 0, 0, -1
    for k in range(n):
        for i in range(nh):
            count(work, violation(work, trajectory.rows[k, i], floors.rows[i]), k + 1, i)
        for i in range(ng):
            count(work, violation(work, trajectory.input_rows[k, i], floors.input_rows[i]), k, nh + nt + i)
    for i in range(nt):
        count(work, violation(work, trajectory.end_rows[i], floors.end_rows[i]), n, nh + i)
    for i in range(program.bounded.shape[0]):
        index, side, limit = program.bounded[i], program.side[i], program.limit[i]
        for k in range(n):
            if index < nx:
                count(work, side * (trajectory.states[k + 1, index] - limit), k + 1, nh + nt + ng + i)
            else:
                count(work, side * (trajectory.inputs[k, index - nx] - limit), k, nh + nt + ng + i)


@kernel
def measure_nominal(work: Workspace) -> None:
    """Largest violation and largest defect of the linearised nominal trajectory, and their sum, into `result`."""
    measure(work, work.nominal)
    total, defect = 0.0, 0.0
    for k in range(work.nominal.inputs.shape[0]):
        for i in range(work.sizes.states):
            value = abs(work.linear.jacobians[k, i, work.sizes.states])
            total += value
            defect = max(defect, value)
    work.result.defect = defect
    work.result.infeasibility += total


@kernel
def move(work: Workspace, scale: float) -> None:
    """Set the nominal trajectory to a point between `saved` and `trial`."""
    go_between(work.saved.states, work.trial.states, scale, work.nominal.states)
    go_between(work.saved.inputs, work.trial.inputs, scale, work.nominal.inputs)


@kernel
def save(work: Workspace) -> None:
    """Keep the nominal trajectory in `saved`."""
    copy_rows(work.nominal.states, work.saved.states)
    copy_rows(work.nominal.inputs, work.saved.inputs)


@kernel
def go_back(model: object, work: Workspace) -> None:
    """Make what is in `saved` the nominal trajectory again, linearised."""
    copy_rows(work.saved.states, work.nominal.states)
    copy_rows(work.saved.inputs, work.nominal.inputs)
    linearize(model, work)


@kernel
def approach(now: Array, new: Array, scale: float, largest: float) -> bool:
    """Move numbers a share of the way to others, and cut them off at ± `largest`."""
    reached = False
    for k in range(now.shape[0]):
        for i in range(now.shape[1]):
            value = now[k, i] + scale * (new[k, i] - now[k, i])
            reached |= abs(value) >= largest
            now[k, i] = max(min(value, largest), -largest)
    return reached


@kernel
def take_multipliers(work: Workspace, scale: float) -> None:
    """Move the multipliers a share of the way to `proposal`; `result` says whether one reached its largest value."""
    now, new, largest = work.multipliers, work.proposal, work.settings.largest_multiplier
    reached = approach(now.rows, new.rows, scale, largest)
    reached |= approach(now.input_rows, new.input_rows, scale, largest)
    if work.sizes.state_bounds > 0:
        reached |= approach(now.states, new.states, scale, largest)
    if work.sizes.input_bounds > 0:
        approach(now.inputs, new.inputs, scale, np.inf)
    for i in range(work.sizes.end_rows):
        value = now.end_rows[i] + scale * (new.end_rows[i] - now.end_rows[i])
        reached |= abs(value) >= largest
        now.end_rows[i] = max(min(value, largest), -largest)
    work.result.priced_out = reached
