"""Small dense linear algebra for kernels: Cholesky factors and triangular solves, row by row, without allocation."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel


@kernel
def cholesky(matrix: Array, size: int, factor: Array) -> bool:
    """Lower factor L of the leading block of a symmetric matrix, M = L Lᵀ."""
    for i in range(size):
        for j in range(i + 1):
            total = matrix[i, j]
            for m in range(j):
                total -= factor[i, m] * factor[j, m]
            if i == j:
                if not total > 1e-14 * (1.0 + abs(matrix[i, i])):
                    return False
                factor[i, i] = np.sqrt(total)
            else:
                factor[i, j] = total / factor[j, j]
    return True


@kernel
def solve_lower(factor: Array, size: int, columns: int, rows: Array) -> None:
    """Product L⁻¹ M in place."""
    for i in range(size):
        for m in range(i):
            scale = factor[i, m]
            for j in range(columns):
                rows[i, j] -= scale * rows[m, j]
        inverse = 1.0 / factor[i, i]
        for j in range(columns):
            rows[i, j] *= inverse


@kernel
def solve_upper(factor: Array, size: int, columns: int, rows: Array) -> None:
    """Product L⁻ᵀ M in place."""
    for i in range(size - 1, -1, -1):
        inverse = 1.0 / factor[i, i]
        for j in range(columns):
            rows[i, j] *= inverse
        for m in range(i):
            scale = factor[i, m]
            for j in range(columns):
                rows[m, j] -= scale * rows[i, j]


@kernel
def go_between(first: Array, second: Array, part: float, out: Array) -> None:
    """Matrix a share of the way from one to another."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = first[i, j] + part * (second[i, j] - first[i, j])


@kernel
def copy_rows(source: Array, target: Array) -> None:
    """Copy a matrix into another of its shape."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]
