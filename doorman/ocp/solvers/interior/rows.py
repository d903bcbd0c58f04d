"""Rows of the interior-point search: their values, first slacks, the barrier function, and the residual of the KKT conditions."""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.ocp.solvers.interior.memory import Interior
from doorman.ocp.solvers.iterations.nominal import total_cost
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.flat_rows import flatten_values, store_multipliers

FIRST_PENALTY = 30.0
"""First penalty w of equalities, in units of the scaled cost: a guess may be far from them, or unable to reach them to first
order, and multipliers that then grow at once bend the Lagrangian more than the cost does."""
LARGEST_PENALTY = 1e7
"""With so much, multipliers follow in one step more than Newton's."""
_NEARER = 0.1
"""Equalities that are not down to this share when their multipliers move cost more from then on,"""
_DEARER = 10.0
"""by this factor."""
_PUSH = 0.01
"""First slacks and distances of inputs from their bounds are no smaller: share of the room between bounds, at most 1."""
_STEPS = 10.0
"""A bound of an input is in reach if it lies within so many first steps: these are right to an order of magnitude."""
_RELAXED = 1e-8
"""Rows may be violated by so much, so that there is an inside."""


@kernel
def fill_values(work: Workspace, interior: Interior) -> None:
    """Values of all rows along the nominal trajectory, after its linearisation."""
    values = interior.values
    flatten_values(work, work.nominal, values)
    for k in range(values.shape[0]):
        for i in range(values.shape[1]):
            if not work.flat.equal[i]:
                values[k, i] -= _RELAXED


@kernel
def push_inside(work: Workspace) -> None:
    """Move the nominal inputs away from their bounds."""
    limits, inputs = work.limits, work.nominal.inputs
    if work.sizes.input_bounds > 0:
        for i in range(work.sizes.inputs):
            low, high = limits.input_lower[i], limits.input_upper[i]
            room = _PUSH * min(
                high - low, 1.0 + max(abs(low) if low > -np.inf else 0.0, abs(high) if high < np.inf else 0.0)
            )
            for k in range(inputs.shape[0]):
                inputs[k, i] = min(max(inputs[k, i], low + room), high - room)


@kernel
def first_slacks(work: Workspace, interior: Interior) -> None:
    """Set the first slacks and multipliers, and the scale of the cost.

    Rows and bounds that are far off begin at their centre, z = τ/s. With more they would weigh on the first steps as active
    ones do, all of them together more than the cost.
    """
    numbers, steepest = interior.numbers, 0.0
    for k in range(interior.gradients.shape[0]):
        for i in range(interior.gradients.shape[1]):
            steepest = max(steepest, abs(interior.gradients[k, i]))
    scale = max(1.0, 0.01 * steepest)
    numbers.scale = scale
    numbers.barrier = 0.1 * scale
    numbers.penalty = FIRST_PENALTY * scale
    numbers.unequal = np.inf
    for k in range(interior.values.shape[0]):
        for i in range(interior.values.shape[1]):
            interior.slacks[k, i] = max(-interior.values[k, i], _PUSH)
            interior.duals[k, i] = 0.0
            if work.flat.applies[k, i] and not work.flat.equal[i]:
                interior.duals[k, i] = min(scale, numbers.barrier / interior.slacks[k, i])
    price_equalities(work, interior)


@kernel
def price_equalities(work: Workspace, interior: Interior) -> None:
    """Multipliers y + w c that the augmented Lagrangian gives the equalities."""
    for k in range(interior.values.shape[0]):
        for i in range(interior.values.shape[1]):
            if work.flat.applies[k, i] and work.flat.equal[i]:
                penalty = interior.numbers.penalty
                interior.duals[k, i] = interior.estimates[k, i] + penalty * interior.values[k, i]


@kernel
def move_estimates(work: Workspace, interior: Interior) -> None:
    """Take the multipliers y + w c for the next y; equalities that have not come nearer to zero cost more from then on."""
    numbers, worst = interior.numbers, 0.0
    for k in range(interior.values.shape[0]):
        for i in range(interior.values.shape[1]):
            if work.flat.applies[k, i] and work.flat.equal[i]:
                interior.estimates[k, i] = interior.duals[k, i]
                worst = max(worst, abs(interior.values[k, i]))
    if worst > _NEARER * numbers.unequal:
        numbers.penalty = min(_DEARER * numbers.penalty, LARGEST_PENALTY * numbers.scale)
    numbers.unequal = worst
    price_equalities(work, interior)


@kernel
def raise_reached(work: Workspace, interior: Interior) -> None:
    """Set the first multipliers of inputs' bounds to the scale of the cost where the step says that these bounds may be reached.

    They damp the first steps. Bounds that are far off for the step damp nothing: a solve without them goes the same way.
    """
    nx, first = work.sizes.states, work.sizes.rows + work.sizes.end_rows + work.sizes.input_rows
    for a in range(nx, nx + work.sizes.inputs):
        reached = False
        for i in range(first, interior.values.shape[1]):
            for k in range(interior.input_steps.shape[0] if work.program.bounded[i - first] == a else 0):
                reached |= interior.slacks[k, i] + _STEPS * interior.slack_steps[k, i] <= 0.0
        for i in range(first, interior.values.shape[1]):
            for k in range(interior.input_steps.shape[0] if reached and work.program.bounded[i - first] == a else 0):
                interior.duals[k, i] = interior.numbers.scale


@kernel
def measure(model: object, work: Workspace, interior: Interior) -> None:
    """Infeasibility θ and barrier function φ of the nominal trajectory, after its linearisation and `fill_values`."""
    infeasibility, logarithms, equalities = 0.0, 0.0, 0.0
    nx = work.sizes.states
    for k in range(work.nominal.inputs.shape[0]):
        for i in range(nx):
            infeasibility += abs(work.linear.jacobians[k, i, nx])
    for k in range(interior.values.shape[0]):
        for i in range(interior.values.shape[1]):
            if work.flat.applies[k, i] and work.flat.equal[i]:
                c = interior.values[k, i]
                equalities += (interior.estimates[k, i] + 0.5 * interior.numbers.penalty * c) * c
            elif work.flat.applies[k, i]:
                infeasibility += abs(interior.values[k, i] + interior.slacks[k, i])
                logarithms += np.log(interior.slacks[k, i])
    cost = total_cost(model, work, work.nominal)
    work.result.cost = cost
    interior.numbers.infeasibility = infeasibility
    interior.numbers.barrier_cost = cost - interior.numbers.barrier * logarithms + equalities


@kernel
def error(work: Workspace, interior: Interior, barrier: float) -> float:
    """Largest residual of the conditions of the barrier problem, in units of the scaled cost; of the problem itself for τ = 0.

    Equalities hold only in the problem itself, barrier problems have an augmented Lagrangian for them.
    """
    nx, nu, n = work.sizes.states, work.sizes.inputs, work.nominal.inputs.shape[0]
    r, scale, worst = interior.residual, interior.numbers.scale, 0.0
    for k in range(n + 1):
        for i in range(nx + nu):
            r[i] = interior.gradients[k, i]
        add_rows(work, interior, k)
        for i in range(nx if k > 0 else 0):
            r[i] -= interior.costates[k - 1, i]
        if k < n:
            for i in range(nx):
                jacobian, costate = work.linear.jacobians[k, i], interior.costates[k, i]
                for j in range(nx):
                    r[j] += jacobian[j] * costate
                for j in range(nu):
                    r[nx + j] += jacobian[nx + 1 + j] * costate
                worst = max(worst, scale * abs(jacobian[nx]))
        for i in range(nx if k > 0 else 0):
            worst = max(worst, abs(r[i]))
        for i in range(nx, nx + nu if k < n else nx):
            worst = max(worst, abs(r[i]))
        for i in range(interior.values.shape[1]):
            if work.flat.applies[k, i] and work.flat.equal[i]:
                if barrier == 0.0:
                    worst = max(worst, scale * abs(interior.values[k, i]))
            elif work.flat.applies[k, i]:
                slack = interior.slacks[k, i]
                worst = max(worst, abs(slack * interior.duals[k, i] - barrier))
                worst = max(worst, scale * abs(interior.values[k, i] + slack))
    return float(worst / scale)


@kernel
def add_rows(work: Workspace, interior: Interior, k: int) -> None:
    """Add node k's rows times their multipliers to the residual."""
    nx, nh, nt, ng = work.sizes.states, work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    r, program, n = interior.residual, work.program, work.nominal.inputs.shape[0]
    for i in range(0 if k == 0 else nh + nt if k == n else nh):
        row = work.linear.row_jacobians[k - 1, i] if i < nh else work.linear.end_row_jacobians[i - nh]
        for j in range(nx):
            r[j] += row[j] * interior.duals[k, i]
    for i in range(ng if k < n else 0):
        row, dual = work.linear.input_row_jacobians[k, i], interior.duals[k, nh + nt + i]
        for j in range(nx):
            r[j] += row[j] * dual
        for j in range(work.sizes.inputs):
            r[nx + j] += row[nx + 1 + j] * dual
    for i in range(program.bounded.shape[0]):
        if work.flat.applies[k, nh + nt + ng + i]:
            r[program.bounded[i]] += program.side[i] * interior.duals[k, nh + nt + ng + i]


@kernel
def export_multipliers(work: Workspace, interior: Interior) -> None:
    """Write the multipliers to where the other solvers have them, `work.multipliers`."""
    n = work.nominal.inputs.shape[0]
    work.multipliers.states[:, :] = 0.0
    work.multipliers.inputs[:, :] = 0.0
    for k in range(n + 1):
        store_multipliers(work, interior.duals[k], k - 1, k if k < n else -1)
