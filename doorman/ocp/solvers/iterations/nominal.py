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
from doorman.ocp.solvers.memory.result import RESULT
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.full_weights import off_diagonal_slope
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows
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
def measure(work: Workspace, trajectory: Trajectory) -> None:
    """Largest violation of a trajectory, its node and row, and the sum of violations, into `result`."""
    nx, n = work.sizes.states, trajectory.inputs.shape[0]
    nh, nt, ng = work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    worst, total, node, row, last, tolerance = 0.0, 0.0, 0, 0, -1, work.settings.feasibility
    finite = 0.0
    for k in range(n):
        for i in range(nh):
            value = violation(work, trajectory.rows[k, i], work.floors.rows[i])
            finite += value
            total += max(value, 0.0)
            if not value <= tolerance:
                last = k + 1
            if value > worst:
                worst, node, row = value, k + 1, i
        for i in range(ng):
            value = violation(work, trajectory.input_rows[k, i], work.floors.input_rows[i])
            finite += value
            total += max(value, 0.0)
            if not value <= tolerance:
                last = max(last, k)
            if value > worst:
                worst, node, row = value, k, nh + nt + i
    for i in range(nt):
        value = violation(work, trajectory.end_rows[i], work.floors.end_rows[i])
        finite += value
        total += max(value, 0.0)
        if not value <= tolerance:
            last = n
        if value > worst:
            worst, node, row = value, n, nh + i
    for i in range(work.program.bounded.shape[0]):
        index, side, limit = work.program.bounded[i], work.program.side[i], work.program.limit[i]
        for k in range(n):
            number = trajectory.states[k + 1, index] if index < nx else trajectory.inputs[k, index - nx]
            value, place = side * (number - limit), k + 1 if index < nx else k
            total += max(value, 0.0)
            if not value <= tolerance:
                last = max(last, place)
            if value > worst:
                worst, node, row = value, place, nh + nt + ng + i
    work.result[RESULT.DEFECT] = 0.0
    work.result[RESULT.VIOLATION] = worst
    work.result[RESULT.INFEASIBILITY] = total if abs(finite) < np.inf else np.inf
    work.result[RESULT.NODE] = node
    work.result[RESULT.ROW] = row
    work.result[RESULT.LAST] = last


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
    work.result[RESULT.DEFECT] = defect
    work.result[RESULT.INFEASIBILITY] += total


@kernel
def move(work: Workspace, scale: float) -> None:
    """Set the nominal trajectory to a point between `saved` and `trial`."""
    nominal, trial, saved = work.nominal, work.trial, work.saved
    for k in range(nominal.inputs.shape[0]):
        for i in range(work.sizes.inputs):
            nominal.inputs[k, i] = saved.inputs[k, i] + scale * (trial.inputs[k, i] - saved.inputs[k, i])
        for i in range(work.sizes.states):
            nominal.states[k + 1, i] = saved.states[k + 1, i] + scale * (
                trial.states[k + 1, i] - saved.states[k + 1, i]
            )


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
    work.result[RESULT.PRICED_OUT] = 1.0 if reached else 0.0
