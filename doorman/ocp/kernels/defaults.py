"""What the solvers call where a model has no kernel of its own: absent constraints and costs, central differences."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.functions import (
    at_node,
    constrain,
    constrain_end,
    constrain_input,
    end_cost,
    expand_end_cost,
    expand_stage_cost,
    linearize_constraints,
    linearize_end_constraints,
    linearize_input_constraints,
    linearize_step,
    slope,
    stage_cost,
    step,
)
from doorman.ocp.kernels.python_functions import FIRST, SECOND


def _by_state(values: Any) -> Any:
    """Kernel of rows of a state and their slopes."""

    @kernel
    def linearize(model: Any, x: Array, h: Array, jacobian: Array) -> None:
        point, ahead, behind = x.copy(), h.copy(), h.copy()
        values(model, x, h)
        for j in range(x.shape[0]):
            reach = FIRST * (1.0 + abs(x[j]))
            point[j] = x[j] + reach
            values(model, point, ahead)
            point[j] = x[j] - reach
            values(model, point, behind)
            point[j] = x[j]
            jacobian[:, j] = (ahead - behind) / (2.0 * reach)

    return linearize


def _by_both(values: Any) -> Any:
    """Kernel of rows of a state and an input, and their slopes."""

    @kernel
    def linearize(model: Any, x: Array, u: Array, g: Array, jacobian: Array) -> None:
        nx, point, ahead, behind = x.shape[0], np.concatenate((x, u)), g.copy(), g.copy()
        values(model, x, u, g)
        for j in range(point.shape[0]):
            middle = point[j]
            reach = FIRST * (1.0 + abs(middle))
            point[j] = middle + reach
            values(model, point[:nx], point[nx:], ahead)
            point[j] = middle - reach
            values(model, point[:nx], point[nx:], behind)
            point[j] = middle
            jacobian[:, j] = (ahead - behind) / (2.0 * reach)

    return linearize


functions.default(linearize_constraints)(_by_state(constrain))
functions.default(linearize_end_constraints)(_by_state(constrain_end))
functions.default(linearize_input_constraints)(_by_both(constrain_input))
_step_and_slopes = _by_both(step)


@functions.default(linearize_step)
@kernel
def _linearize_step(model: Any, x: Array, u: Array, jacobian: Array) -> None:
    _step_and_slopes(model, x, u, np.empty_like(x), jacobian)


@functions.default(constrain)
@functions.default(constrain_end)
@kernel
def _no_rows(model: Any, x: Array, h: Array) -> None:
    pass


@functions.default(constrain_input)
@kernel
def _no_input_rows(model: Any, x: Array, u: Array, g: Array) -> None:
    pass


@functions.default(stage_cost)
@kernel
def _no_stage_cost(model: Any, x: Array, u: Array) -> float:
    return 0.0


@functions.default(end_cost)
@kernel
def _no_end_cost(model: Any, x: Array) -> float:
    return 0.0


@functions.default(expand_stage_cost)
@kernel
def _expand_stage_cost(model: Any, x: Array, u: Array, gradient: Array, hessian: Array) -> None:
    _expand(model, np.concatenate((x, u)), x.shape[0], gradient, hessian)


@functions.default(expand_end_cost)
@kernel
def _expand_end_cost(model: Any, x: Array, gradient: Array, hessian: Array) -> None:
    _expand(model, x.copy(), x.shape[0], gradient, hessian)


@kernel
def _expand(model: Any, point: Array, nx: int, gradient: Array, hessian: Array) -> None:
    """Slopes and curvature of the cost of a state, or of a state and an input."""
    for i in range(point.shape[0]):
        reach = SECOND * (1.0 + abs(point[i]))
        for j in range(i + 1):
            other, total = SECOND * (1.0 + abs(point[j])), 0.0
            for a in (1.0, -1.0):
                for b in (1.0, -1.0):
                    shifted = point.copy()
                    shifted[i] += a * reach
                    shifted[j] += b * other
                    total += a * b * _cost(model, shifted, nx)
            hessian[i, j] = hessian[j, i] = total / (4.0 * reach * other)
        ahead, behind = point.copy(), point.copy()
        reach = FIRST * (1.0 + abs(point[i]))
        ahead[i] += reach
        behind[i] -= reach
        gradient[i] = (_cost(model, ahead, nx) - _cost(model, behind, nx)) / (2.0 * reach)


@kernel
def _cost(model: Any, point: Array, nx: int) -> float:
    """Cost of the last state, or of a state and an input."""
    return end_cost(model, point) if point.shape[0] == nx else stage_cost(model, point[:nx], point[nx:])  # type: ignore[no-any-return]


# Models of Python functions run the plain bodies of what follows, which call nothing but a model's functions.


@functions.default(functions.linearize_horizon)
@kernel
def _linearize_horizon(
    model: Any, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    nx, nu, nh = states.shape[1], inputs.shape[1], rows.shape[1]
    plain, ahead, slopes = np.zeros((nx, nx + nu)), np.empty(nx), np.zeros((nh, nx))
    for k in range(inputs.shape[0]):
        linearize_step(at_node(model, k), states[k], inputs[k], plain)
        step(at_node(model, k), states[k], inputs[k], ahead)
        jacobians[k, :, :nx] = plain[:, :nx]
        jacobians[k, :, nx] = ahead - states[k + 1]
        jacobians[k, :, nx + 1 : nx + 1 + nu] = plain[:, nx:]
        if nh > 0:
            linearize_constraints(at_node(model, k + 1), states[k + 1], rows[k], slopes)
            row_jacobians[k, :, :nx] = slopes


@functions.default(functions.constrain_horizon)
@kernel
def _constrain_horizon(model: Any, states: Array, rows: Array) -> None:
    for k in range(rows.shape[0]):
        constrain(at_node(model, k + 1), states[k + 1], rows[k])


@functions.default(functions.curve_horizon)
@kernel
def _curve_horizon(
    model: Any, states: Array, inputs: Array, costates: Array, prices: Array, nh: int, nt: int, ng: int, gradients: Array,
    hessians: Array,
) -> None:  # fmt: skip
    """Differences of slopes; the model's own cost counts as its expansion has it."""
    n, nx, nz = inputs.shape[0], states.shape[1], gradients.shape[1]
    point, ahead, behind, corner, none = np.zeros(nz), np.zeros(nz), np.zeros(nz), np.zeros((nx, nx)), np.zeros(0)
    for k in range(n + 1):
        node, price, gradient, hessian = at_node(model, k), prices[k], gradients[k], hessians[k]
        gradient[:] = 0.0
        hessian[:, :] = 0.0
        point[:nx] = states[k]
        if k < n:
            point[nx:] = inputs[k]
            expand_stage_cost(node, states[k], inputs[k], gradient, hessian)
        else:
            corner[:, :] = 0.0
            expand_end_cost(node, states[k], gradient[:nx], corner)
            hessian[:nx, :nx] = corner
        costate, of_inputs = (costates[k], price[nh + nt : nh + nt + ng]) if k < n else (none, none)
        of_state, of_end = price[:nh] if k > 0 else none, price[nh : nh + nt] if k == n else none
        for j in range(nz if k < n else nx):
            middle = point[j]
            reach = FIRST * (1.0 + abs(middle))
            point[j] = middle + reach
            slope(node, point[:nx], point[nx:], costate, of_state, of_end, of_inputs, ahead)
            point[j] = middle - reach
            slope(node, point[:nx], point[nx:], costate, of_state, of_end, of_inputs, behind)
            point[j] = middle
            half = 0.25 * (ahead - behind) / reach
            hessian[:, j] += half
            hessian[j, :] += half


@functions.default(slope)
@kernel
def _slope(
    model: Any, x: Array, u: Array, costate: Array, of_state: Array, of_end: Array, of_inputs: Array, out: Array
) -> None:
    nx, nz = x.shape[0], out.shape[0]
    out[:] = 0.0
    if costate.shape[0] > 0:
        slopes = np.zeros((nx, nz))
        linearize_step(model, x, u, slopes)
        for i in range(nx):
            out += costate[i] * slopes[i]
    if of_inputs.shape[0] > 0:
        slopes = np.zeros((of_inputs.shape[0], nz))
        linearize_input_constraints(model, x, u, np.zeros(of_inputs.shape[0]), slopes)
        for i in range(of_inputs.shape[0]):
            out += of_inputs[i] * slopes[i]
    if of_state.shape[0] > 0:
        slopes = np.zeros((of_state.shape[0], nx))
        linearize_constraints(model, x, np.zeros(of_state.shape[0]), slopes)
        for i in range(of_state.shape[0]):
            out[:nx] += of_state[i] * slopes[i]
    if of_end.shape[0] > 0:
        slopes = np.zeros((of_end.shape[0], nx))
        linearize_end_constraints(model, x, np.zeros(of_end.shape[0]), slopes)
        for i in range(of_end.shape[0]):
            out[:nx] += of_end[i] * slopes[i]
