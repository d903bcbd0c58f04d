r"""First-order optimality of a trajectory, checked without any solver's kernels.

With costates :math:`p_k = L_{x,k} + A_k^T p_{k+1}` from the last state backwards, where L_x gathers cost, constraints and
bounds of state k with their multipliers, the residual is the largest entry of :math:`L_{u,k} + B_k^T p_{k+1}`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.supplying import is_implemented


def kkt_residual(problem: Any, states: Array, inputs: Array, multipliers: Any) -> float:
    """Largest gradient of the Lagrangian by an input."""
    return conditions(problem, states, inputs, multipliers)[0]


def conditions(problem: Any, states: Array, inputs: Array, multipliers: Any) -> tuple[float, Array]:
    """Largest gradient of the Lagrangian by an input, and the costates on the way."""
    model, cost, dt = problem.model, problem.cost, problem.time_step
    n, nx, nu = problem.horizon, problem.nx, problem.nu
    state_weights, terminal_weights, input_weights, cross = cost.matrices()
    own = is_implemented(functions.stage_cost, type(model)) or is_implemented(functions.end_cost, type(model))
    costate = terminal_weights @ (states[n] - cost.state_goal) + _of_state(problem, states, multipliers, n)
    if own:
        gradient = np.zeros(nx)
        functions.expand_end_cost(functions.at_node(model, n), states[n].copy(), gradient, np.zeros((nx, nx)))
        costate = costate + gradient
    worst, costates = 0.0, np.zeros((n, nx))
    for k in range(n - 1, -1, -1):
        costates[k] = costate
        x, u = states[k].copy(), inputs[k].copy()
        jacobian, gradient = np.zeros((nx, nx + nu)), np.zeros(nx + nu)
        functions.linearize_step(functions.at_node(model, k), x, u, jacobian)
        if own:
            functions.expand_stage_cost(functions.at_node(model, k), x, u, gradient, np.zeros((nx + nu, nx + nu)))
        state_error, input_error = x - cost.state_goal, u - cost.input_goal
        gradient[:nx] += dt * (state_weights @ state_error + cross.T @ input_error)
        gradient[nx:] += dt * (input_weights @ input_error + cross @ state_error) + multipliers.inputs[k]
        if problem.n_input_constraints:
            g, slopes = np.zeros(problem.n_input_constraints), np.zeros((problem.n_input_constraints, nx + nu))
            functions.linearize_input_constraints(functions.at_node(model, k), x, u, g, slopes)
            gradient += slopes.T @ multipliers.input_rows[k]
        gradient += jacobian.T @ costate
        worst = max(worst, float(np.abs(gradient[nx:]).max()))
        costate = gradient[:nx] + (_of_state(problem, states, multipliers, k) if k > 0 else 0.0)
    return worst, costates


def _of_state(problem: Any, states: Array, multipliers: Any, k: int) -> Array:
    """Gradient by state k of its constraints and bounds with their multipliers, shape (nx,)."""
    x, nx = states[k].copy(), problem.nx
    total: Array = multipliers.states[k - 1].copy()
    if problem.n_constraints:
        h, slopes = np.zeros(problem.n_constraints), np.zeros((problem.n_constraints, nx))
        functions.linearize_constraints(functions.at_node(problem.model, k), x, h, slopes)
        total += slopes.T @ multipliers.rows[k - 1]
    if k == problem.horizon and problem.n_end_constraints:
        h, slopes = np.zeros(problem.n_end_constraints), np.zeros((problem.n_end_constraints, nx))
        functions.linearize_end_constraints(functions.at_node(problem.model, k), x, h, slopes)
        total += slopes.T @ multipliers.end_rows
    return total
