r"""One node of a Riccati sweep, on rows padded to the vector width.

The Jacobian's rows are [A | B | e] with the defect e, the value function's [V_xx | · | V_x], so that one product carries
Hessian and gradient together. Eliminating the input rows of [Q_zx | Q_zu | Q_z] by Cholesky, Q_uu = L Lᵀ, leaves
[Y | Lᵀ | y] = L⁻¹[Q_ux | Q_uu | Q_u], and

.. math:: V_{xx} = Q_{xx} - Y^T Y,\quad V_x = Q_x - Y^T y,\quad [K | k] = -L^{-T}[Y | y]

Every inner loop runs over a whole row with a compile-time length and sums before it stores: this is what makes numba
vectorise it. Rows that are not set yet are zero, so that the sums need no bounds that vary.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.ocp.workspace import Workspace

Array = NDArray[np.float64]


@kernel
def terminal_value(work: Workspace) -> None:
    """Value function of the last state; sums of the sweep to zero."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    last, weights, value = work.nominal.states[work.nominal.inputs.shape[0]], work.weights, work.scratch.value
    value[:, :] = 0.0
    for i in range(nx):
        value[i, i] = weights.terminal[i]
        value[i, nx + nu] = weights.terminal[i] * (last[i] - weights.state_goal[i])
    work.scratch.result[2] = 0.0
    work.scratch.result[3] = 0.0


@kernel
def expand(work: Workspace, k: int, regularization: float) -> None:
    """Quadratic model of node k: `scratch.hessian` = [Q_zx | Q_zu | Q_z]."""
    nx, nu, width = len(work.sizes.states), len(work.sizes.inputs), len(work.sizes.width)
    jacobian, scratch, weights = work.policy.jacobians[k], work.scratch, work.weights
    value, product, hessian = scratch.value, scratch.product, scratch.hessian
    for i in range(nx):
        for j in range(width):
            total = 0.0
            for m in range(nx):
                total += value[i, m] * jacobian[m, j]
            product[i, j] = total
        product[i, nx + nu] += value[i, nx + nu]
    for i in range(nx + nu):
        for j in range(width):
            total = 0.0
            for m in range(nx):
                total += jacobian[m, i] * product[m, j]
            hessian[i, j] = total
    x, u = work.nominal.states[k], work.nominal.inputs[k]
    for i in range(nx):
        hessian[i, i] += weights.state[i]
        hessian[i, nx + nu] += weights.state[i] * (x[i] - weights.state_goal[i])
    for i in range(nu):
        hessian[nx + i, nx + i] += weights.input[i] * (1.0 + regularization)
        hessian[nx + i, nx + nu] += weights.input[i] * (u[i] - weights.input_goal[i])


@kernel
def eliminate(work: Workspace, k: int) -> bool:
    """`scratch.half` = [Y | Lᵀ | y], the factor, and the value before node k; False if Q_uu is not positive definite."""
    nx, nu, width = len(work.sizes.states), len(work.sizes.inputs), len(work.sizes.width)
    scratch = work.scratch
    half, hessian, value, factor = scratch.half, scratch.hessian, scratch.value, work.policy.factors[k]
    half[:, :] = 0.0
    for b in range(nu):
        diagonal = hessian[nx + b, nx + b]
        for j in range(width):
            total = hessian[nx + b, j]
            for a in range(nu):
                total -= half[a, nx + b] * half[a, j]
            hessian[nx + b, j] = total
        pivot = hessian[nx + b, nx + b]
        if not pivot > 1e-14 * (1.0 + abs(diagonal)):
            return False
        inverse = 1.0 / np.sqrt(pivot)
        for j in range(width):
            half[b, j] = hessian[nx + b, j] * inverse
        for a in range(b, nu):
            factor[a, b] = half[b, nx + a]
    for i in range(nx):
        for j in range(width):
            total = hessian[i, j]
            for a in range(nu):
                total -= half[a, i] * half[a, j]
            value[i, j] = total
    for i in range(nx):
        for j in range(i):
            mean = 0.5 * (value[i, j] + value[j, i])
            value[i, j] = mean
            value[j, i] = mean
    return True


@kernel
def substitute(work: Workspace, k: int, half: Array) -> None:
    """Gains of node k, [K | · | k] = −L⁻ᵀ `half`."""
    nu, width = len(work.sizes.inputs), len(work.sizes.width)
    gains, factor = work.policy.gains[k], work.policy.factors[k]
    gains[:, :] = 0.0
    for b in range(nu - 1, -1, -1):
        inverse = -1.0 / factor[b, b]
        for j in range(width):
            total = half[b, j]
            for a in range(nu):
                total += half_column(factor, a, b) * gains[a, j]
            gains[b, j] = total * inverse


@kernel
def half_column(factor: Array, row: int, column: int) -> float:
    """Entry of the lower factor; those above its diagonal are zero."""
    return factor[row, column] if row >= column else 0.0
