r"""The part of the quadratic cost off the diagonals, for problems that have one.

.. math:: \tfrac12 x^T Q x + \tfrac12 u^T R u + u^T S x

with x and u from their goals, Q and R without their diagonals; at the last state L instead of Q.
"""

from __future__ import annotations

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.solvers.memory.parts import Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace


@kernel
def off_diagonal_cost(work: Workspace, at: Trajectory, k: int) -> float:
    """Value of this part of the cost at node k of a trajectory."""
    weights, nx, n = work.weights, work.sizes.states, at.inputs.shape[0]
    matrix, total = weights.off_state if k < n else weights.off_terminal, 0.0
    for i in range(nx):
        slope = 0.0
        for j in range(nx):
            slope += matrix[i, j] * (at.states[k, j] - weights.state_goal[j])
        total += 0.5 * slope * (at.states[k, i] - weights.state_goal[i])
    for a in range(work.sizes.inputs if k < n else 0):
        slope = 0.0
        for b in range(work.sizes.inputs):
            slope += 0.5 * weights.off_input[a, b] * (at.inputs[k, b] - weights.input_goal[b])
        for j in range(nx):
            slope += weights.cross[a, j] * (at.states[k, j] - weights.state_goal[j])
        total += slope * (at.inputs[k, a] - weights.input_goal[a])
    return float(total)


@kernel
def off_diagonal_slope(work: Workspace, at: Trajectory, k: int, gradient: Array) -> None:
    """Add the gradient of this part of the cost at node k of a trajectory."""
    weights, nx, n = work.weights, work.sizes.states, at.inputs.shape[0]
    matrix = weights.off_state if k < n else weights.off_terminal
    for j in range(nx):
        error = at.states[k, j] - weights.state_goal[j]
        for i in range(nx):
            gradient[i] += matrix[i, j] * error
        for a in range(work.sizes.inputs if k < n else 0):
            gradient[nx + a] += weights.cross[a, j] * error
    for b in range(work.sizes.inputs if k < n else 0):
        error = at.inputs[k, b] - weights.input_goal[b]
        for a in range(work.sizes.inputs):
            gradient[nx + a] += weights.off_input[a, b] * error
        for i in range(nx):
            gradient[i] += weights.cross[b, i] * error


@kernel
def off_diagonal_curvature(work: Workspace, k: int, hessian: Array) -> None:
    """Add the Hessian of this part of the cost at node k."""
    weights, nx, n = work.weights, work.sizes.states, work.nominal.inputs.shape[0]
    matrix = weights.off_state if k < n else weights.off_terminal
    for i in range(nx):
        for j in range(nx):
            hessian[i, j] += matrix[i, j]
    for a in range(work.sizes.inputs if k < n else 0):
        for j in range(nx):
            hessian[nx + a, j] += weights.cross[a, j]
            hessian[j, nx + a] += weights.cross[a, j]
        for b in range(work.sizes.inputs):
            hessian[nx + a, nx + b] += weights.off_input[a, b]
