r"""Mean and covariance of one filter: prediction, and rows fused one by one.

.. math::
    P^+ = F P F^T + Q,\qquad S = h P h^T + r,\quad K = P h^T / S,\quad P \leftarrow (I - K h) P (I - K h)^T + r K K^T .

Rows have independent noise, so that one after the other is the same as all at once. The last form (Joseph's) is symmetric, and
positive for any K. Jacobians are sparse: only their nonzeros are multiplied. Rows of matrices are filled up with zeros to whole
registers.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.estimation.kernels.memory import FilterMemory
from doorman.estimation.kernels.printed_functions import call_printed
from doorman.numba_types.lanes import load, store, zero

FOUR = (0,) * 4
"""Width of a register, as kernels take it."""

_SLACK = 1e-9
"""Relative rounding that a covariance's 2 × 2 minors may have."""


@kernel
def predict(memory: FilterMemory, j: int, inputs: Array, h: float) -> None:
    """Hypothesis j after a time h."""
    mean, covariance = memory.means[j], memory.covariances[j]
    n, predictions = mean.shape[0], memory.predictions
    call_printed(predictions.addresses[j], mean, inputs, memory.parameters, h, memory.out)
    ends, columns = predictions.slope_ends[j], predictions.slope_columns[j]
    half, across = memory.half, memory.half_across
    for i in range(n):
        mean[i] = memory.out[i]
    _times_rows(memory.out, n, ends, columns, covariance, half)
    for i in range(n):
        for k in range(n):
            across[k, i] = half[i, k]
    _times_rows(memory.out, n, ends, columns, across, half)
    for i in range(n):
        for k in range(i + 1):
            covariance[i, k] = 0.5 * (half[i, k] + half[k, i])
    first, places = n + ends[n], memory.noise_places[j]
    for e in range(places[0]):
        covariance[places[1 + 2 * e], places[2 + 2 * e]] += memory.out[first + e]
    for i in range(n):
        for k in range(i):
            covariance[k, i] = covariance[i, k]
    keep_inside(memory, mean)


@kernel
def _times_rows(out: Array, n: int, ends: Array, columns: Array, matrix: Array, product: Array) -> None:
    """F times a matrix."""
    for i in range(n):
        for k in range(0, matrix.shape[1], 4):
            total = zero(FOUR)
            for e in range(ends[i], ends[i + 1]):
                total += out[n + e] * load(matrix, (columns[e], k), FOUR)
            store(product, (i, k), total)


@kernel
def fuse_rows(memory: FilterMemory, j: int, ends: Array, columns: Array, first: int, count: int) -> tuple[float, float]:
    """Fuse `count` rows, whose slopes begin at `first` of what the function wrote: NIS, and log det S."""
    mean, covariance, before = memory.means[j], memory.covariances[j], memory.before
    n, distance, logarithm = mean.shape[0], 0.0, 0.0
    for i in range(n):
        before[i] = mean[i]
    for row in range(count):
        innovation, variance = memory.innovations[row], memory.variances[row]
        for e in range(ends[row], ends[row + 1]):
            innovation -= memory.out[first + e] * (mean[columns[e]] - before[columns[e]])
        spread = spread_of(memory, covariance, ends, columns, first, row) + variance
        distance += innovation * innovation / spread
        logarithm += np.log(spread)
        for i in range(n):
            memory.gain[i] = memory.row[i] / spread
            mean[i] += memory.gain[i] * innovation
        _narrow(memory, covariance, ends, columns, first, row, variance)
    keep_inside(memory, mean)
    return distance, logarithm


@kernel
def spread_of(memory: FilterMemory, covariance: Array, ends: Array, columns: Array, first: int, row: int) -> float:
    """Variance h P hᵀ of a row; P hᵀ stays in the memory."""
    spread, product, out = 0.0, memory.row, memory.out
    for k in range(0, covariance.shape[1], 4):
        total = zero(FOUR)
        for e in range(ends[row], ends[row + 1]):
            total += out[first + e] * load(covariance, (columns[e], k), FOUR)
        store(product, k, total)
    for e in range(ends[row], ends[row + 1]):
        spread += out[first + e] * product[columns[e]]
    return spread


@kernel
def _narrow(
    memory: FilterMemory, covariance: Array, ends: Array, columns: Array, first: int, row: int, variance: float
) -> None:
    """Joseph's form of what a row leaves of a covariance."""
    n, gain, product = covariance.shape[0], memory.gain, memory.row
    for i in range(n):
        own = gain[i]
        for k in range(0, covariance.shape[1], 4):
            store(covariance, (i, k), load(covariance, (i, k), FOUR) - own * load(product, k, FOUR))
        left = 0.0
        for e in range(ends[row], ends[row + 1]):
            left += covariance[i, columns[e]] * memory.out[first + e]
        left = variance * own - left
        for k in range(0, covariance.shape[1], 4):
            store(covariance, (i, k), load(covariance, (i, k), FOUR) + left * load(gain, k, FOUR))
    for i in range(n):
        for k in range(i):
            covariance[i, k] = covariance[k, i] = 0.5 * (covariance[i, k] + covariance[k, i])


@kernel
def keep_inside(memory: FilterMemory, mean: Array) -> None:
    """Put states back to their ends; NaN stays."""
    for i in range(mean.shape[0]):
        if mean[i] < memory.lower[i]:
            mean[i] = memory.lower[i]
        elif mean[i] > memory.upper[i]:
            mean[i] = memory.upper[i]


@kernel
def has_meaning(memory: FilterMemory, j: int) -> bool:
    """Whether mean and covariance are finite, and no variance or 2 × 2 minor is negative."""
    mean, covariance = memory.means[j], memory.covariances[j]
    for i in range(mean.shape[0]):
        if not (np.isfinite(mean[i]) and np.isfinite(covariance[i, i]) and covariance[i, i] >= 0.0):
            return False
        for k in range(i):
            if not covariance[i, k] ** 2 <= (1.0 + _SLACK) * covariance[i, i] * covariance[k, k]:
                return False
    return True
