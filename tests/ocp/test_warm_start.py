"""Shifting a plan, against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.ocp.warm_start import nearest_shift, shift_rows

SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS, st.integers(1, 12), st.floats(0.0, 15.0), st.booleans())
def test_shifted_rows_are_interpolated_and_the_last_one_is_held(seed: int, m: int, shift: float, plain: bool) -> None:
    rows = np.random.default_rng(seed).normal(size=(m, 3))
    out = np.empty_like(rows)
    (shift_rows.py_func if plain else shift_rows)(rows, shift, out)
    at = np.arange(m) + shift
    expected = np.column_stack([np.interp(at, np.arange(m), column) for column in rows.T])
    np.testing.assert_allclose(out, expected, atol=1e-12)


def test_no_shift_copies_the_bits(rng: np.random.Generator) -> None:
    rows = rng.normal(size=(7, 4))
    rows.flags.writeable = False
    out = np.empty_like(rows)
    shift_rows(rows, 0.0, out)
    np.testing.assert_array_equal(out, rows)


@given(SEEDS, st.integers(1, 6), st.booleans())
def test_nearest_point_of_the_polyline(seed: int, limit: int, plain: bool) -> None:
    """No point of a fine sampling of the polyline is nearer than the one found."""
    rng = np.random.default_rng(seed)
    states = np.cumsum(rng.normal(size=(7, 4)), axis=0)
    state = states[0] + rng.normal(size=4)
    weights = rng.uniform(0.0, 5.0, 4)
    shift = (nearest_shift.py_func if plain else nearest_shift)(states, state, weights, limit)
    assert 0.0 <= shift <= limit

    def distance(at: np.ndarray | float) -> np.ndarray:
        points = np.column_stack([np.interp(np.atleast_1d(at), np.arange(7), column) for column in states.T])
        return (points - state) ** 2 @ weights

    assert distance(shift)[0] <= distance(np.linspace(0.0, limit, 400 * limit + 1)).min() + 1e-12


@pytest.mark.parametrize("shift", [0.0, 0.25, 1.0, 1.75, 2.0])
def test_a_point_on_the_polyline_is_found(shift: float, rng: np.random.Generator) -> None:
    states = np.cumsum(rng.uniform(0.5, 1.0, size=(7, 4)), axis=0)
    node, part = int(shift), shift % 1.0
    point = (1.0 - part) * states[node] + part * states[node + 1]
    assert nearest_shift(states, point, np.ones(4), 2) == pytest.approx(shift, abs=1e-12)


def test_a_plan_at_rest_is_not_shifted() -> None:
    assert nearest_shift(np.ones((5, 3)), np.zeros(3), np.ones(3), 2) == 0.0


def test_the_limit_and_the_end_of_the_plan_hold() -> None:
    line = np.arange(5.0)[:, None]
    assert nearest_shift(line, np.array([9.0]), np.ones(1), 2) == 2.0
    assert nearest_shift(line, np.array([9.0]), np.ones(1), 50) == 4.0
    assert nearest_shift(line, np.array([-9.0]), np.ones(1), 2) == 0.0
