r"""The cost beyond the diagonals of its weights: what full matrices add, and the model's own.

.. math:: \tfrac12 x^T Q x + \tfrac12 u^T R u + u^T S x

with x and u from their goals, Q and R without their diagonals; at the last state L instead of Q.
"""

from __future__ import annotations

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.kernels.functions import at_node, expand_end_cost, expand_stage_cost
from doorman.ocp.solvers.memory.parts import Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace


@kernel
def error(work: Workspace, at: Trajectory, k: int, i: int) -> float:
    """Distance of a state's or an input's number from its goal."""
    nx, weights = work.sizes.states, work.weights
    if i < nx:
        return float(at.states[k, i] - weights.state_goal[i])
    return float(at.inputs[k, i - nx] - weights.input_goal[i - nx])


@kernel
def off_diagonal_slope(work: Workspace, at: Trajectory, k: int, gradient: Array) -> float:
    """Value of the full matrices' part at node k of a trajectory; its gradient is added."""
    matrix, total = work.weights.off_stage if k < at.inputs.shape[0] else work.weights.off_end, 0.0
    for i in range(matrix.shape[0]):
        slope = 0.0
        for j in range(matrix.shape[0]):
            slope += matrix[i, j] * error(work, at, k, j)
        gradient[i] += slope
        total += 0.5 * slope * error(work, at, k, i)
    return total


@kernel
def off_diagonal_curvature(work: Workspace, k: int, hessian: Array) -> None:
    """Add the Hessian of that part at node k."""
    matrix = work.weights.off_stage if k < work.nominal.inputs.shape[0] else work.weights.off_end
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[0]):
            hessian[i, j] += matrix[i, j]


@kernel
def expand_beyond_diagonals(model: object, work: Workspace, k: int) -> None:
    """Gradient and Hessian at node k of the nominal trajectory, into `node.gradient` and `node.hessian`."""
    nx, n, nominal = work.sizes.states, work.nominal.inputs.shape[0], work.nominal
    gradient, hessian, own = work.node.gradient, work.node.hessian, work.sizes.extra_cost > 0
    if own and k < n:
        expand_stage_cost(at_node(model, k), nominal.states[k], nominal.inputs[k], gradient, hessian)
    else:
        gradient[:] = 0.0
        hessian[:, :] = 0.0
    if own and k == n:
        corner = hessian[:nx, :nx].copy()
        expand_end_cost(at_node(model, n), nominal.states[n], gradient[:nx], corner)
        hessian[:nx, :nx] = corner
    if work.sizes.full_cost > 0:
        off_diagonal_slope(work, nominal, k, gradient)
        off_diagonal_curvature(work, k, hessian)
