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
    linearize_constraints,
    linearize_step,
    stage_cost,
    step,
)

_FIRST = 6e-6
"""Relative step of a first difference: the cube root of the rounding error."""
_SECOND = 1e-4
"""Relative step of a second difference: its fourth root."""


@functions.default(functions.linearize_step)
@kernel
def _linearize_step(model: Any, x: Array, u: Array, jacobian: Array) -> None:
    nx, nu = x.shape[0], u.shape[0]
    point, control, ahead, behind = x.copy(), u.copy(), np.empty(nx), np.empty(nx)
    for j in range(nx + nu):
        values, i = (point, j) if j < nx else (control, j - nx)
        middle = values[i]
        reach = _FIRST * (1.0 + abs(middle))
        values[i] = middle + reach
        step(model, point, control, ahead)
        values[i] = middle - reach
        step(model, point, control, behind)
        values[i] = middle
        for row in range(nx):
            jacobian[row, j] = (ahead[row] - behind[row]) / (2.0 * reach)


@functions.default(functions.constrain)
@kernel
def _constrain(model: Any, x: Array, h: Array) -> None:
    pass


@functions.default(functions.linearize_constraints)
@kernel
def _linearize_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    point, ahead, behind = x.copy(), h.copy(), h.copy()
    constrain(model, x, h)
    for j in range(x.shape[0]):
        reach = _FIRST * (1.0 + abs(x[j]))
        point[j] = x[j] + reach
        constrain(model, point, ahead)
        point[j] = x[j] - reach
        constrain(model, point, behind)
        point[j] = x[j]
        for row in range(h.shape[0]):
            jacobian[row, j] = (ahead[row] - behind[row]) / (2.0 * reach)


@functions.default(functions.constrain_input)
@kernel
def _constrain_input(model: Any, x: Array, u: Array, g: Array) -> None:
    pass


@functions.default(functions.linearize_input_constraints)
@kernel
def _linearize_input_constraints(model: Any, x: Array, u: Array, g: Array, jacobian: Array) -> None:
    nx, nu = x.shape[0], u.shape[0]
    point, control, ahead, behind = x.copy(), u.copy(), g.copy(), g.copy()
    constrain_input(model, x, u, g)
    for j in range(nx + nu):
        values, i = (point, j) if j < nx else (control, j - nx)
        middle = values[i]
        reach = _FIRST * (1.0 + abs(middle))
        values[i] = middle + reach
        constrain_input(model, point, control, ahead)
        values[i] = middle - reach
        constrain_input(model, point, control, behind)
        values[i] = middle
        for row in range(g.shape[0]):
            jacobian[row, j] = (ahead[row] - behind[row]) / (2.0 * reach)


@functions.default(functions.constrain_end)
@kernel
def _constrain_end(model: Any, x: Array, h: Array) -> None:
    pass


@functions.default(functions.linearize_end_constraints)
@kernel
def _linearize_end_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    point, ahead, behind = x.copy(), h.copy(), h.copy()
    constrain_end(model, x, h)
    for j in range(x.shape[0]):
        reach = _FIRST * (1.0 + abs(x[j]))
        point[j] = x[j] + reach
        constrain_end(model, point, ahead)
        point[j] = x[j] - reach
        constrain_end(model, point, behind)
        point[j] = x[j]
        for row in range(h.shape[0]):
            jacobian[row, j] = (ahead[row] - behind[row]) / (2.0 * reach)


@functions.default(functions.stage_cost)
@kernel
def _stage_cost(model: Any, x: Array, u: Array) -> float:
    return 0.0


@functions.default(functions.expand_stage_cost)
@kernel
def _expand_stage_cost(model: Any, x: Array, u: Array, gradient: Array, hessian: Array) -> None:
    nx, nz = x.shape[0], x.shape[0] + u.shape[0]
    point = np.concatenate((x, u))
    for i in range(nz):
        reach = _SECOND * (1.0 + abs(point[i]))
        for j in range(i + 1):
            other = _SECOND * (1.0 + abs(point[j]))
            total = 0.0
            for a in (1.0, -1.0):
                for b in (1.0, -1.0):
                    shifted = point.copy()
                    shifted[i] += a * reach
                    shifted[j] += b * other
                    total += a * b * stage_cost(model, shifted[:nx], shifted[nx:])
            hessian[i, j] = total / (4.0 * reach * other)
            hessian[j, i] = hessian[i, j]
        ahead, behind = point.copy(), point.copy()
        reach = _FIRST * (1.0 + abs(point[i]))
        ahead[i] += reach
        behind[i] -= reach
        gradient[i] = (stage_cost(model, ahead[:nx], ahead[nx:]) - stage_cost(model, behind[:nx], behind[nx:])) / (
            2.0 * reach
        )


@functions.default(functions.end_cost)
@kernel
def _end_cost(model: Any, x: Array) -> float:
    return 0.0


@functions.default(functions.expand_end_cost)
@kernel
def _expand_end_cost(model: Any, x: Array, gradient: Array, hessian: Array) -> None:
    for i in range(x.shape[0]):
        reach = _SECOND * (1.0 + abs(x[i]))
        for j in range(i + 1):
            other = _SECOND * (1.0 + abs(x[j]))
            total = 0.0
            for a in (1.0, -1.0):
                for b in (1.0, -1.0):
                    shifted = x.copy()
                    shifted[i] += a * reach
                    shifted[j] += b * other
                    total += a * b * end_cost(model, shifted)
            hessian[i, j] = total / (4.0 * reach * other)
            hessian[j, i] = hessian[i, j]
        ahead, behind = x.copy(), x.copy()
        reach = _FIRST * (1.0 + abs(x[i]))
        ahead[i] += reach
        behind[i] -= reach
        gradient[i] = (end_cost(model, ahead) - end_cost(model, behind)) / (2.0 * reach)


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
        for i in range(nx):
            for j in range(nx):
                jacobians[k, i, j] = plain[i, j]
            jacobians[k, i, nx] = ahead[i] - states[k + 1, i]
            for j in range(nu):
                jacobians[k, i, nx + 1 + j] = plain[i, nx + j]
        if nh > 0:
            linearize_constraints(at_node(model, k + 1), states[k + 1], rows[k], slopes)
            for i in range(nh):
                for j in range(nx):
                    row_jacobians[k, i, j] = slopes[i, j]


@functions.default(functions.constrain_horizon)
@kernel
def _constrain_horizon(model: Any, states: Array, rows: Array) -> None:
    for k in range(rows.shape[0]):
        constrain(at_node(model, k + 1), states[k + 1], rows[k])
