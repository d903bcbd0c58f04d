"""Kernels that the printed modules share: nodes into lanes and back, and the positive part of a Hessian."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.lanes import load, store

Indices = NDArray[np.int64]

LANES = 8
"""Nodes side by side."""
WIDTH = (0,) * LANES
"""Number of lanes as kernels take it: the length of a tuple."""

_FOUR = (0,) * 4
_LONG = 7
"""Nonzeros from which on a residual's slopes are taken as a full row: side by side, and the zeros with them."""
_SWEEPS = 30
_SMALL = 1e-14


@kernel
def gather(rows: Array, first: int, stop: int, lanes: Array) -> None:
    """Rows from `first` to before `stop` into lanes, as many as there are; the last one again where there are no more."""
    for side in range(LANES):
        k = min(first + side, stop - 1)
        for i in range(lanes.shape[0]):
            lanes[i, side] = rows[k, i]


@kernel
def spread(values: Array, lanes: Array) -> None:
    """One node into every lane.

    That is as fast as one lane alone, and the kernels for lanes are compiled anyway.
    """
    for i in range(values.shape[0]):
        for side in range(LANES):
            lanes[i, side] = values[i]


@kernel
def put_slopes(out: Array, first: int, rows: Indices, columns: Indices, jacobian: Array) -> None:
    """Nonzeros of a Jacobian from the first lane into a full matrix."""
    jacobian[:, :] = 0.0
    for i in range(rows.shape[0]):
        jacobian[rows[i], columns[i]] = out[first + i, 0]


@kernel
def scatter_values(out: Array, first: int, rows: Array) -> None:
    """Values of h from lanes into one row for each node."""
    for side in range(min(LANES, rows.shape[0] - first)):
        for i in range(rows.shape[1]):
            rows[first + side, i] = out[i, side]


@kernel
def scatter_curvature(
    out: Array, first: int, stop: int, rows: Indices, columns: Indices, gradients: Array, hessians: Array
) -> None:
    """Gradients and symmetric Hessians from lanes; the nonzeros of the lower halves stand behind the gradients."""
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
def add_entries(values: Array, first: int, rows: Indices, columns: Indices, matrix: Array) -> None:
    """Add numbers that stand side by side to the entries of a matrix."""
    for i in range(rows.shape[0]):
        matrix[rows[i], columns[i]] += values[first + i]


@kernel
def add_squares(squares: Array, ends: Indices, columns: Indices, gradient: Array, hessian: Array) -> None:
    """Add gradient Jᵀ W r and Gauss and Newton's Hessian Jᵀ W J of ½ Σ w r²."""
    count, size = ends.shape[0] - 1, gradient.shape[0]
    row = squares[squares.shape[0] - size :]
    for k in range(count):
        residual, weight, first, stop = squares[k], squares[count + k], ends[k], ends[k + 1]
        if stop - first < _LONG:
            for i in range(first, stop):
                weighted = weight * squares[2 * count + i]
                gradient[columns[i]] += weighted * residual
                for j in range(first, stop):
                    hessian[columns[i], columns[j]] += weighted * squares[2 * count + j]
            continue
        for j in range(size):
            row[j] = 0.0
        for i in range(first, stop):
            row[columns[i]] = squares[2 * count + i]
        for i in range(first, stop):
            weighted = weight * squares[2 * count + i]
            gradient[columns[i]] += weighted * residual
            add_row(hessian, columns[i], weighted, row)


@kernel
def add_row(matrix: Array, i: int, factor: float, row: Array) -> None:
    """Add a multiple of a row to row i of a matrix."""
    whole = row.shape[0] - row.shape[0] % len(_FOUR)
    for j in range(0, whole, len(_FOUR)):
        store(matrix, (i, j), load(matrix, (i, j), _FOUR) + factor * load(row, j, _FOUR))
    for j in range(whole, row.shape[0]):
        matrix[i, j] += factor * row[j]


@kernel
def keep_positive(matrix: Array, vectors: Array) -> None:
    """Positive part of a symmetric matrix, in place: negative eigenvalues become 0 (cyclic Jacobi rotations)."""
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
