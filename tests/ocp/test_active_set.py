"""The guess of a node's active set, against trying every set there is, and small linear algebra against numpy."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.ocp.active_set import ROW_TOLERANCE, gather_schur, solve_dual
from doorman.ocp.linear_algebra import cholesky, solve_lower, solve_upper

SEEDS = st.integers(0, 2**32 - 1)


def best_of_all_sets(schur: np.ndarray, values: np.ndarray) -> np.ndarray:
    """λ ≥ 0 with r = c − Sλ ≤ 0 and λᵀr = 0, by trying all active sets; for strictly convex S there is one solution."""
    n = len(values)
    for size in range(n + 1):
        for rows in itertools.combinations(range(n), size):
            multipliers = np.zeros(n)
            chosen = list(rows)
            if chosen:
                multipliers[chosen] = np.linalg.solve(schur[np.ix_(chosen, chosen)], values[chosen])
            if (multipliers >= 0.0).all() and (values - schur @ multipliers <= 1e-9).all():
                return multipliers
    raise AssertionError("no solution")


def guess(schur: np.ndarray, values: np.ndarray, first: np.ndarray) -> tuple[bool, np.ndarray, np.ndarray, np.ndarray]:
    n = len(values)
    active, multipliers, factor = first.copy(), np.zeros(n), np.zeros((n, n))
    settled = solve_dual(schur, values, active, np.zeros(n, dtype=np.int64), factor, multipliers)
    return settled, active, multipliers, factor


@given(SEEDS, st.integers(1, 7), st.integers(0, 4))
def test_a_guess_that_settles_is_the_solution(seed: int, n: int, more: int) -> None:
    """From any first set; what is found is the one solution, or it says that it has found none."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(n, n + more))
    schur = rows @ rows.T + 0.01 * np.eye(n)
    values = rng.normal(size=n)
    settled, active, multipliers, factor = guess(schur, values, rng.random(n) < 0.5)
    if settled:
        residual = values - schur @ multipliers
        assert residual.max() <= ROW_TOLERANCE + 1e-9
        assert (multipliers >= 0.0).all()
        assert not multipliers[~active].any()
        np.testing.assert_allclose(residual[active], 0.0, atol=1e-8)
        scale = 1.0 + np.abs(multipliers).max()
        np.testing.assert_allclose(multipliers, best_of_all_sets(schur, values), atol=1e-6 * scale)
        count = int(active.sum())
        lower = np.tril(factor[:count, :count])
        np.testing.assert_allclose(lower @ lower.T, schur[np.ix_(active, active)], rtol=1e-9, atol=1e-12)


def test_it_settles_nearly_always_in_eight_variables(rng: np.random.Generator) -> None:
    settled = 0
    for _ in range(200):
        rows = rng.normal(size=(6, 8))
        settled += guess(rows @ rows.T, rng.normal(size=6), np.zeros(6, dtype=np.bool_))[0]
    assert settled >= 190


def test_nothing_violated_is_nothing_active(rng: np.random.Generator) -> None:
    rows = rng.normal(size=(6, 8))
    settled, active, multipliers, _ = guess(rows @ rows.T, -rng.random(6), np.ones(6, dtype=np.bool_))
    assert settled
    assert not active.any()
    np.testing.assert_array_equal(multipliers, 0.0)


def test_rows_that_contradict_each_other_do_not_settle() -> None:
    rows = np.array([[1.0, 0.0], [-1.0, 0.0]])
    settled, *_ = guess(rows @ rows.T, np.ones(2), np.zeros(2, dtype=np.bool_))
    assert not settled


def test_a_row_that_no_input_moves_does_not_settle() -> None:
    rows = np.array([[1.0, 0.0], [0.0, 0.0]])
    settled, *_ = guess(rows @ rows.T, np.array([-1.0, 1.0]), np.zeros(2, dtype=np.bool_))
    assert not settled


def test_compiled_guess_equals_its_plain_twin(rng: np.random.Generator) -> None:
    for _ in range(20):
        rows, values = rng.normal(size=(6, 8)), rng.normal(size=6)
        schur, first = rows @ rows.T, rng.random(6) < 0.5
        compiled = guess(schur, values, first)
        active, multipliers, factor = first.copy(), np.zeros(6), np.zeros((6, 6))
        settled = solve_dual.py_func(schur, values, active, np.zeros(6, dtype=np.int64), factor, multipliers)
        assert settled == compiled[0]
        np.testing.assert_array_equal(active, compiled[1])
        np.testing.assert_allclose(multipliers, compiled[2], rtol=1e-9, atol=1e-11)


def test_gathered_block_is_that_of_the_active_rows(rng: np.random.Generator) -> None:
    rows = rng.normal(size=(6, 8))
    active = np.array([True, False, True, True, False, False])
    indices, gathered = np.zeros(6, dtype=np.int64), np.zeros((6, 6))
    assert gather_schur(rows @ rows.T, active, indices, gathered) == 3
    assert indices[:3].tolist() == [0, 2, 3]
    expected = np.tril((rows @ rows.T)[np.ix_(active, active)])
    np.testing.assert_allclose(gathered[:3, :3], expected, rtol=1e-11)


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
