"""Templates of the module that computes one problem's expressions."""

HEAD = '''"""Kernels of a problem with {nx} states and {nu} inputs, printed from CasADi expressions.

States x: {x}. Inputs u: {u}. Parameters p: {p}. Parameters q of each node: {q}.
"""

from typing import NamedTuple

import numpy as np

from doorman.compilation import kernel
from doorman.numba_types.straight import straight
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.printed.loading import remade
from doorman.ocp.kernels.runtime import (
    LANES,
    WIDTH,
    add_entries,
    add_squares,
    gather,
    keep_positive,
    put_slopes,
    scatter_curvature,
    scatter_values,
    spread,
)

ROWS = {rows}
INTEGRATORS = {integrators}
NODE_PARAMETERS = {nq}
NAMES = {names}
EQUALITIES = {equalities}


class Model(NamedTuple):
    """Numbers that change without compiling, and memory of the kernels."""

    time_step: float
    parameters: np.ndarray
    node_parameters: np.ndarray
    x_lanes: np.ndarray
    u_lanes: np.ndarray
    q_lanes: np.ndarray
    out: np.ndarray
    curvature: np.ndarray
    squares: np.ndarray
    costates: np.ndarray
    prices: np.ndarray

    @classmethod
    def of(cls, time_step, parameters, node_parameters):
        """Numbers with fresh memory."""
        x, u, q = np.zeros(({nx}, LANES)), np.zeros(({nu}, LANES)), np.zeros(({nq}, LANES))
        out, curvature, squares = np.zeros(({outputs}, LANES)), np.zeros(({bent}, {bent})), np.zeros({squares})
        costates, prices = np.zeros(({nx}, LANES)), np.zeros(({prices}, LANES))
        return cls(float(time_step), parameters, node_parameters, x, u, q, out, curvature, squares, costates, prices)

    def __reduce__(self):
        return remade, (TEXT, self.time_step, self.parameters, self.node_parameters)
'''

NODE = '''
class Node(NamedTuple):
    """What the kernels of one node need; `q` are its parameters."""

    time_step: float
    parameters: np.ndarray
    q: np.ndarray
    x_lanes: np.ndarray
    u_lanes: np.ndarray
    q_lanes: np.ndarray
    out: np.ndarray
    curvature: np.ndarray
    squares: np.ndarray


@functions.implement(functions.at_node, Model)
def at_node(model, k):
    q = model.node_parameters[k]
    return Node(
        model.time_step, model.parameters, q, model.x_lanes, model.u_lanes, model.q_lanes, model.out, model.curvature,
        model.squares,
    )
'''

LINEARIZE_STEP = """@kernel
def linearize_step(model, x, u, jacobian):
    spread(x, model.x_lanes)
    spread(u, model.u_lanes){spread}
    step_lanes(model, model.x_lanes, model.u_lanes, model.q_lanes, model.out)
    put_slopes(model.out, x.shape[0], STEP_ROWS, STEP_COLUMNS, jacobian)"""

LINEARIZE_ROWS = """@kernel
def linearize_constraints(model, x, h, jacobian):
    spread(x, model.x_lanes){spread}
    rows_lanes(model, model.x_lanes, model.q_lanes, model.out)
    for i in range(h.shape[0]):
        h[i] = model.out[i, 0]
    put_slopes(model.out, h.shape[0], ROW_ROWS, ROW_COLUMNS, jacobian)"""

HORIZON = """
{tables}


@straight
def scatter_step(values, ahead, jacobian):
    {scatter_step}


@functions.implement(functions.linearize_horizon, Model)
@kernel
def linearize_horizon(model, states, inputs, jacobians, rows, row_jacobians):
    n = inputs.shape[0]
    for first in range(0, n, LANES):
        gather(states, first, n, model.x_lanes)
        gather(inputs, first, n, model.u_lanes)
        gather(model.node_parameters, first, n, model.q_lanes)
        step_lanes(model, model.x_lanes, model.u_lanes, model.q_lanes, model.out)
        for side in range(min(LANES, n - first)):
            scatter_step(model.out[:, side], states[first + side + 1], jacobians[first + side])
"""

HORIZON_ROWS = """        gather(states, first + 1, n + 1, model.x_lanes)
        gather(model.node_parameters, first + 1, n + 1, model.q_lanes)
        rows_lanes(model, model.x_lanes, model.q_lanes, model.out)
        for side in range(min(LANES, n - first)):
            scatter_rows(model.out[:, side], rows[first + side], row_jacobians[first + side])


@straight
def scatter_rows(values, row, jacobian):
    {scatter_rows}


{tables}


@functions.implement(functions.constrain_horizon, Model)
@kernel
def constrain_horizon(model, states, rows):
    n = rows.shape[0]
    for first in range(0, n, LANES):
        gather(states, first + 1, n + 1, model.x_lanes)
        gather(model.node_parameters, first + 1, n + 1, model.q_lanes)
        row_values_lanes(model, model.x_lanes, model.q_lanes, model.out)
        scatter_values(model.out, first, rows)
"""

CURVATURE = """
@functions.implement(functions.curve_horizon, Model)
@kernel
def curve_horizon(model, states, inputs, costates, prices, nh, nt, ng, gradients, hessians):
    n = inputs.shape[0]
    for first in range(0, n, LANES):
        gather(states, first, n, model.x_lanes)
        gather(inputs, first, n, model.u_lanes)
        gather(model.node_parameters, first, n, model.q_lanes)
        gather(costates, first, n, model.costates)
        gather(prices, first, n, model.prices)
        curve_lanes(model, model.x_lanes, model.u_lanes, model.q_lanes, model.costates, model.prices, model.out)
        scatter_curvature(model.out, first, n, CURVE_ROWS, CURVE_COLUMNS, gradients, hessians)
    gradients[n, :] = 0.0
    hessians[n, :, :] = 0.0
    curve_end(functions.at_node(model, n), states[n], prices[n], gradients[n], hessians[n])
"""
