"""Second derivatives of the Lagrangian where a model has no kernel of its own: differences of its first derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.functions import (
    at_node,
    expand_end_cost,
    expand_stage_cost,
    linearize_constraints,
    linearize_end_constraints,
    linearize_input_constraints,
    linearize_step,
)

_REACH = 6e-6
"""Relative step of a difference: the cube root of the rounding error."""


@functions.default(functions.curve_horizon)
@kernel
def _curve_horizon(
    model: Any, states: Array, inputs: Array, costates: Array, prices: Array, counts: tuple[int, int, int],
    gradients: Array, hessians: Array,
) -> None:  # fmt: skip
    """The model's own cost counts as its expansion has it."""
    n, nx, nz = inputs.shape[0], states.shape[1], gradients.shape[1]
    point, ahead, behind, corner = np.zeros(nz), np.zeros(nz), np.zeros(nz), np.zeros((nx, nx))
    for k in range(n + 1):
        gradient, hessian = gradients[k], hessians[k]
        gradient[:] = 0.0
        hessian[:, :] = 0.0
        point[:nx] = states[k]
        if k < n:
            point[nx:] = inputs[k]
            expand_stage_cost(at_node(model, k), states[k], inputs[k], gradient, hessian)
        else:
            corner[:, :] = 0.0
            expand_end_cost(at_node(model, k), states[k], gradient[:nx], corner)
            hessian[:nx, :nx] = corner
        for j in range(nz if k < n else nx):
            middle = point[j]
            reach = _REACH * (1.0 + abs(middle))
            point[j] = middle + reach
            _slope(model, k, point, costates, prices[k], counts, ahead)
            point[j] = middle - reach
            _slope(model, k, point, costates, prices[k], counts, behind)
            point[j] = middle
            for i in range(nz):
                half = 0.25 * (ahead[i] - behind[i]) / reach
                hessian[i, j] += half
                hessian[j, i] += half


@kernel
def _slope(
    model: Any, k: int, point: Array, costates: Array, prices: Array, counts: tuple[int, int, int], out: Array
) -> None:
    """Gradient of pᵀf + yᵀ(h, h_N, g) of node k."""
    n, nx, nz = costates.shape[0], costates.shape[1], out.shape[0]
    nh, nt, ng = counts
    x, u, node = point[:nx], point[nx:], at_node(model, k)
    out[:] = 0.0
    if k < n:
        slopes = np.zeros((nx, nz))
        linearize_step(node, x, u, slopes)
        _add(slopes, costates[k], out)
        if ng > 0:
            slopes = np.zeros((ng, nz))
            linearize_input_constraints(node, x, u, np.zeros(ng), slopes)
            _add(slopes, prices[nh + nt : nh + nt + ng], out)
    if k > 0 and nh > 0:
        slopes = np.zeros((nh, nx))
        linearize_constraints(node, x, np.zeros(nh), slopes)
        _add(slopes, prices[:nh], out)
    if k == n and nt > 0:
        slopes = np.zeros((nt, nx))
        linearize_end_constraints(node, x, np.zeros(nt), slopes)
        _add(slopes, prices[nh : nh + nt], out)


@kernel
def _add(slopes: Array, prices: Array, out: Array) -> None:
    """Jacobianᵀ y."""
    for i in range(slopes.shape[0]):
        for j in range(slopes.shape[1]):
            out[j] += slopes[i, j] * prices[i]
