"""Small factorisations for kernels, against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.ocp.solvers.sweeps.linear_algebra import cholesky, copy_rows, solve_lower, solve_upper

SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS, st.integers(1, 9), st.integers(1, 12))
def test_cholesky_and_triangular_solves(seed: int, n: int, columns: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n + 2))
    matrix = np.zeros((n + 1, n + 2))
    matrix[:n, :n] = root @ root.T + 0.01 * np.eye(n)
    factor = np.zeros_like(matrix)
    assert cholesky(matrix, n, factor)
    lower = np.linalg.cholesky(matrix[:n, :n])
    np.testing.assert_allclose(factor[:n, :n], lower, rtol=1e-9, atol=1e-10)
    rows = rng.normal(size=(n, columns + 3))
    for solve, triangle in ((solve_lower, lower), (solve_upper, lower.T)):
        solved = rows.copy()
        solve(factor, n, columns, solved)
        expected = np.linalg.solve(triangle, rows[:, :columns])
        np.testing.assert_allclose(solved[:, :columns], expected, rtol=1e-7, atol=1e-7)
        np.testing.assert_array_equal(solved[:, columns:], rows[:, columns:])


@pytest.mark.parametrize("matrix", [np.array([[1.0, 2.0], [2.0, 1.0]]), np.zeros((2, 2)), np.full((2, 2), np.nan)])
def test_cholesky_refuses_what_is_not_positive_definite(matrix: np.ndarray) -> None:
    assert not cholesky(matrix, 2, np.zeros((2, 2)))
    assert not cholesky.py_func(matrix, 2, np.zeros((2, 2)))


def test_cholesky_in_place_equals_its_plain_twin(rng: np.random.Generator) -> None:
    root = rng.normal(size=(5, 7))
    compiled, plain = root @ root.T, root @ root.T
    assert cholesky(compiled, 5, compiled) and cholesky.py_func(plain, 5, plain)
    np.testing.assert_allclose(np.tril(compiled), np.tril(plain), rtol=1e-13)


def test_copied_rows_are_a_copy(rng: np.random.Generator) -> None:
    source, target = rng.normal(size=(4, 3)), np.zeros((4, 3))
    copy_rows(source, target)
    np.testing.assert_array_equal(source, target)
    target[0, 0] = 7.0
    assert source[0, 0] != 7.0
