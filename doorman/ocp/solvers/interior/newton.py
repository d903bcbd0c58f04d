r"""Newton step of the interior-point search, by one Riccati sweep.

With slacks, c + s = 0, and multipliers z, s z = τ, eliminated, every row adds

.. math:: w\,c_z^T c_z\ \text{to the Hessian},\quad \big(\tau/s + w (c + s)\big)\,c_z^T\ \text{to the gradient},\quad w = z/s

Equalities have no slack but a penalty w and multipliers y of either sign: the step is Newton's for the augmented Lagrangian, and
w c + y takes the place of the gradient's factor. The Hessian is that of the Lagrangian. Where it is not convex enough for a
minimum, a multiple of the identity is added, as in IPOPT (Wächter and Biegler 2006).
"""

from __future__ import annotations

from doorman.compilation import kernel
from doorman.ocp.kernels.functions import curve_horizon
from doorman.ocp.solvers.interior.memory import Interior
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.full_weights import off_diagonal_curvature, off_diagonal_slope
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows
from doorman.ocp.solvers.sweeps.sized import add_square, eliminate, multiply_dynamics, multiply_gains
from doorman.ocp.solvers.sweeps.sweep import add_input_row


@kernel
def expand(model: object, work: Workspace, interior: Interior) -> None:
    """Gradients of the cost and Hessians of the Lagrangian at all nodes."""
    nx, nu, n = work.sizes.states, work.sizes.inputs, work.nominal.inputs.shape[0]
    states, inputs, weights = work.nominal.states, work.nominal.inputs, work.weights
    curve_horizon(
        model, states, inputs, interior.costates, interior.duals, work.sizes.rows, work.sizes.end_rows,
        work.sizes.input_rows, interior.gradients, interior.hessians,
    )  # fmt: skip
    for k in range(n + 1):
        for i in range(nx):
            share = weights.state[i] if k < n else weights.terminal[i]
            interior.gradients[k, i] += share * (states[k, i] - weights.state_goal[i])
            interior.hessians[k, i, i] += share
        for i in range(nu if k < n else 0):
            interior.gradients[k, nx + i] += weights.input[i] * (inputs[k, i] - weights.input_goal[i])
            interior.hessians[k, nx + i, nx + i] += weights.input[i]
        if work.sizes.full_cost > 0:
            off_diagonal_slope(work, work.nominal, k, interior.gradients[k])
            off_diagonal_curvature(work, k, interior.hessians[k])


@kernel
def weight(work: Workspace, interior: Interior, k: int, i: int) -> float:
    """Weight w of a row: z/s, or the penalty of an equality."""
    if work.flat.equal[i]:
        return float(interior.numbers.penalty)
    return float(interior.duals[k, i] / interior.slacks[k, i])


@kernel
def force(work: Workspace, interior: Interior, k: int, i: int) -> float:
    """What a row adds to the gradient, in units of its own slope times its weight."""
    if work.flat.equal[i]:
        return float(interior.values[k, i] + interior.estimates[k, i] / interior.numbers.penalty)
    return float(interior.numbers.barrier / interior.duals[k, i] + interior.values[k, i] + interior.slacks[k, i])


@kernel
def add_state_rows(work: Workspace, interior: Interior, k: int) -> None:
    """Add rows and bounds of state k to its value function."""
    nx, nh, nt, ng = work.sizes.states, work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    value, linear, program, n = work.node.value, work.linear, work.program, work.nominal.inputs.shape[0]
    for i in range(nh + nt if k == n else nh):
        row = linear.row_jacobians[k - 1, i] if i < nh else linear.end_row_jacobians[i - nh]
        row[nx] = force(work, interior, k, i)
        stiff = weight(work, interior, k, i)
        add_square(work.tiles, k, work, row, stiff)
        row[nx] = 0.0
    for i in range(program.bounded.shape[0]):
        a, at = program.bounded[i], nh + nt + ng + i
        if a < nx:
            stiff = weight(work, interior, k, at)
            value[a, a] += stiff
            value[a, nx] += stiff * program.side[i] * force(work, interior, k, at)


@kernel
def set_base(work: Workspace, interior: Interior, k: int, regularization: float) -> None:
    """Lagrangian of node k with its mixed rows and input bounds, into `node.base_x` and `node.base_u`."""
    nx, nu = work.sizes.states, work.sizes.inputs
    nh, nt, ng = work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    base_x, base_u, program = work.node.base_x, work.node.base_u, work.program
    hessian, gradient = interior.hessians[k], interior.gradients[k]
    for i in range(nx):
        for j in range(nx):
            base_x[i, j] = hessian[i, j]
        base_x[i, i] += regularization
        base_x[i, nx] = gradient[i]
    for i in range(nu):
        for j in range(nx):
            base_u[i, j] = hessian[nx + i, j]
        base_u[i, nx] = gradient[nx + i]
        for j in range(nu):
            base_u[i, nx + 1 + j] = hessian[nx + i, nx + j]
        base_u[i, nx + 1 + i] += regularization
    for i in range(ng):
        row, at = work.linear.input_row_jacobians[k, i], nh + nt + i
        add_input_row(work, row, force(work, interior, k, at), weight(work, interior, k, at))
    for i in range(program.bounded.shape[0]):
        a, at = program.bounded[i] - nx, nh + nt + ng + i
        if a >= 0:
            stiff = weight(work, interior, k, at)
            base_u[a, nx + 1 + a] += stiff
            base_u[a, nx] += stiff * program.side[i] * force(work, interior, k, at)


@kernel
def sweep(work: Workspace, interior: Interior, regularization: float) -> bool:
    """Policy of all nodes, by one Riccati sweep."""
    nx, n = work.sizes.states, work.nominal.inputs.shape[0]
    node, value = work.node, work.node.value
    value[:, :] = 0.0
    node.base_x[:, :] = 0.0
    node.base_u[:, :] = 0.0
    for i in range(nx):
        for j in range(nx):
            value[i, j] = interior.hessians[n, i, j]
        value[i, i] += regularization
        value[i, nx] = interior.gradients[n, i]
    for k in range(n - 1, -1, -1):
        add_state_rows(work, interior, k + 1)
        copy_rows(value, interior.behind[k])
        set_base(work, interior, k, regularization)
        if not eliminate(work.tiles, k, work):
            return False
    return True


@kernel
def step_along(work: Workspace, interior: Interior) -> None:
    """Newton step of the last sweep, into `interior`: states, inputs, costates, slacks and multipliers.

    `interior.numbers` gets the longest steps that keep slacks and multipliers positive, and the slope of φ.
    """
    nx, nu, n = work.sizes.states, work.sizes.inputs, work.nominal.inputs.shape[0]
    step, slope, largest = work.node.step, 0.0, 0.0
    step[:] = 0.0
    interior.numbers.primal = 1.0
    interior.numbers.dual = 1.0
    for k in range(n):
        step[nx] = 1.0
        for i in range(nu):
            step[nx + 1 + i] = 0.0
        multiply_gains(work.tiles, k, work)
        for i in range(nu):
            interior.input_steps[k, i] = step[nx + 1 + i]
            largest = max(largest, work.weights.metric[i] * abs(step[nx + 1 + i]))
            slope += interior.gradients[k, nx + i] * step[nx + 1 + i]
        for i in range(nx):
            slope += interior.gradients[k, i] * step[i]
        slope += step_rows(work, interior, k)
        multiply_dynamics(work.tiles, k, work)
        for i in range(nx):
            interior.state_steps[k + 1, i] = step[i]
            total = interior.behind[k, i, nx]
            for j in range(nx):
                total += interior.behind[k, i, j] * step[j]
            interior.next_costates[k, i] = total
    work.result.change = largest
    for i in range(nx):
        slope += interior.gradients[n, i] * step[i]
    interior.numbers.slope = slope + step_rows(work, interior, n)


@kernel
def step_rows(work: Workspace, interior: Interior, k: int) -> float:
    """Steps of node k's slacks and multipliers, from `node.step`."""
    nx, nh, nt, ng = work.sizes.states, work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    step, program, numbers, slope = work.node.step, work.program, interior.numbers, 0.0
    barrier, reach = numbers.barrier, 1.0 - max(0.0, min(0.01, numbers.barrier / numbers.scale))
    for i in range(interior.values.shape[1]):
        if work.flat.applies[k, i]:
            change = 0.0
            if i < nh + nt:
                row = work.linear.row_jacobians[k - 1, i] if i < nh else work.linear.end_row_jacobians[i - nh]
                for j in range(nx):
                    change += row[j] * step[j]
            elif i < nh + nt + ng:
                row = work.linear.input_row_jacobians[k, i - nh - nt]
                for j in range(nx):
                    change += row[j] * step[j]
                for j in range(nx + 1, nx + 1 + work.sizes.inputs):
                    change += row[j] * step[j]
            else:
                index = program.bounded[i - nh - nt - ng]
                change = program.side[i - nh - nt - ng] * step[index if index < nx else index + 1]
            if work.flat.equal[i]:
                slope += interior.duals[k, i] * change
                continue
            slack, dual = interior.slacks[k, i], interior.duals[k, i]
            slack_step = -interior.values[k, i] - slack - change
            dual_step = (barrier - dual * slack_step) / slack - dual
            interior.slack_steps[k, i] = slack_step
            interior.dual_steps[k, i] = dual_step
            slope -= barrier * slack_step / slack
            if slack_step < 0.0:
                numbers.primal = min(numbers.primal, -reach * slack / slack_step)
            if dual_step < 0.0:
                numbers.dual = min(numbers.dual, -reach * dual / dual_step)
    return slope
