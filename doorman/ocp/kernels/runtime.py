"""Kernels that the printed modules share: nodes into lanes and back, and the positive part of a Hessian."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LANES = 8
"""Nodes side by side."""
WIDTH = (0,) * LANES
"""The same as kernels take it: a tuple of that length."""

_SWEEPS = 30
_SMALL = 1e-14


@kernel
def gather(rows: Array, first: int, stop: int, lanes: Array) -> None:
    """Rows from `first` to before `stop` into lanes, as many as there are; the last one again where there are no more.

    Of longer rows, the first entries.
    """
    for side in range(LANES):
        k = min(first + side, stop - 1)
        for i in range(lanes.shape[0]):
            lanes[i, side] = rows[k, i]


@kernel
def scatter_step(out: Array, first: int, states: Array, rows: Indices, columns: Indices, jacobians: Array) -> None:
    """Next states and nonzeros of [A | B] from lanes into [A | e | B] with the defect e."""
    nx = states.shape[1]
    for side in range(min(LANES, jacobians.shape[0] - first)):
        k = first + side
        for i in range(nx):
            jacobians[k, i, nx] = out[i, side] - states[k + 1, i]
        for i in range(rows.shape[0]):
            jacobians[k, rows[i], columns[i]] = out[nx + i, side]


@kernel
def scatter_rows(out: Array, first: int, rows: Array) -> None:
    """Values of h from lanes."""
    for side in range(min(LANES, rows.shape[0] - first)):
        for i in range(rows.shape[1]):
            rows[first + side, i] = out[i, side]


@kernel
def scatter_slopes(out: Array, first: int, at: Indices, columns: Indices, rows: Array, slopes: Array) -> None:
    """Nonzeros of h_x, which stand behind the values, from lanes."""
    for side in range(min(LANES, rows.shape[0] - first)):
        for i in range(at.shape[0]):
            slopes[first + side, at[i], columns[i]] = out[rows.shape[1] + i, side]


@kernel
def scatter_curvature(
    out: Array, first: int, stop: int, rows: Indices, columns: Indices, gradients: Array, hessians: Array
) -> None:
    """Gradients, and behind them the nonzeros of symmetric Hessians' lower halves, from lanes."""
    size = gradients.shape[1]
    for side in range(min(LANES, stop - first)):
        k = first + side
        for i in range(size):
            gradients[k, i] = out[i, side]
            for j in range(size):
                hessians[k, i, j] = 0.0
        for i in range(rows.shape[0]):
            value = out[size + i, side]
            hessians[k, rows[i], columns[i]] = value
            hessians[k, columns[i], rows[i]] = value


@kernel
def keep_positive(matrix: Array, vectors: Array) -> None:
    """Positive part of a symmetric matrix, in place: negative eigenvalues become 0 (cyclic Jacobi rotations).

    Args:
        matrix: Shape (n, n).
        vectors: Memory for the eigenvectors, of at least that shape.
    """
    n = matrix.shape[0]
    scale = 0.0
    for i in range(n):
        for j in range(n):
            vectors[i, j] = 1.0 if i == j else 0.0
            scale = max(scale, abs(matrix[i, j]))
    for _ in range(_SWEEPS):
        off = 0.0
        for p in range(n - 1):
            for q in range(p + 1, n):
                off = max(off, abs(matrix[p, q]))
                _rotate(matrix, vectors, n, p, q)
        if not off > _SMALL * scale:
            break
    _compose(matrix, vectors, n)


@kernel
def _rotate(matrix: Array, vectors: Array, n: int, p: int, q: int) -> None:
    """One Jacobi rotation, after which entry (p, q) is 0."""
    if matrix[p, q] == 0.0:
        return
    theta = 0.5 * (matrix[q, q] - matrix[p, p]) / matrix[p, q]
    t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
    t = -t if theta < 0.0 else t
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for k in range(n):
        a, b = matrix[k, p], matrix[k, q]
        matrix[k, p], matrix[k, q] = c * a - s * b, s * a + c * b
        a, b = vectors[k, p], vectors[k, q]
        vectors[k, p], vectors[k, q] = c * a - s * b, s * a + c * b
    for k in range(n):
        a, b = matrix[p, k], matrix[q, k]
        matrix[p, k], matrix[q, k] = c * a - s * b, s * a + c * b


@kernel
def _compose(matrix: Array, vectors: Array, n: int) -> None:
    """V max(Λ, 0) Vᵀ from a diagonal matrix Λ, in place."""
    values = matrix[0]  # written last
    for i in range(n):
        values[i] = max(matrix[i, i], 0.0)
    corner = 0.0
    for k in range(n):
        corner += vectors[0, k] * values[k] * vectors[0, k]
    for i in range(1, n):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += vectors[i, k] * values[k] * vectors[j, k]
            matrix[i, j] = total
    matrix[0, 0] = corner
    for i in range(1, n):
        for j in range(i):
            matrix[j, i] = matrix[i, j]
