r"""First-order optimality of a trajectory, checked without any solver's kernels.

With costates :math:`p_k = L_{x,k} + A_k^T p_{k+1}` from the last state backwards, where L_x gathers cost, constraints and
bounds of state k with their multipliers, the residual is the largest entry of :math:`L_{u,k} + B_k^T p_{k+1}`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.ocp.kernels import functions


class Conditions(NamedTuple):
    """How well first-order conditions hold."""

    residual: float
    """Largest gradient of the Lagrangian by an input."""
    costates: Array
    """(N, nx)."""


def conditions(problem: Any, states: Array, inputs: Array, multipliers: Any) -> Conditions:
    """Conditions of a trajectory with its multipliers."""
    model, cost, dt = problem.model, problem.cost, problem.time_step
    n, nx, nu = problem.horizon, problem.nx, problem.nu
    state_weights, terminal_weights, input_weights, cross = cost.matrices()
    own, none = functions.has_own_cost(type(model)), np.zeros(0)
    worst, costates, costate, slopes = 0.0, np.zeros((n, nx)), none, np.zeros(nx + nu)
    for k in range(n, -1, -1):
        node, x, u = functions.at_node(model, k), states[k].copy(), inputs[k].copy() if k < n else none
        gradient, curvature = np.zeros(nx + len(u)), np.zeros((nx + len(u), nx + len(u)))
        error = x - cost.state_goal
        if k < n:
            if own:
                functions.expand_stage_cost(node, x, u, gradient, curvature)
            input_error = u - cost.input_goal
            gradient[:nx] += dt * (state_weights @ error + cross.T @ input_error)
            gradient[nx:] += dt * (input_weights @ input_error + cross @ error) + multipliers.inputs[k]
        else:
            if own:
                functions.expand_end_cost(node, x, gradient, curvature)
            gradient += terminal_weights @ error
        of_state, of_input = multipliers.rows[k - 1] if k > 0 else none, multipliers.input_rows[k] if k < n else none
        of_end = multipliers.end_rows if k == n else none
        functions.slope(node, x, u, costate, *(each.copy() for each in (of_state, of_end, of_input)), slopes)
        gradient += slopes[: len(gradient)]
        worst = max(worst, float(np.abs(gradient[nx:]).max(initial=0.0)))
        if k > 0:
            costate = costates[k - 1] = gradient[:nx] + multipliers.states[k - 1]
    return Conditions(worst, costates)
