"""Active rows and bounds of one node as vector code, against a plain twin, for any number of them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.ocp.solvers.sweeps.active_set import mark_rows
from doorman.ocp.solvers.sweeps.node_bounds import mark_bounds

Array = NDArray[np.float64]
Sides = NDArray[np.int8]

SCALE = 3.0


@kernel
def _rows(k: int, rows: Array, multipliers: Array, active: Sides, proposal: Array, floors: Array) -> tuple[int, bool]:
    return mark_rows(k, rows, multipliers, SCALE, floors, active, proposal)


@kernel
def _bounds(
    k: int, count: tuple[int, ...], values: Array, ends: Array, multipliers: Array, active: Sides, proposal: Array
) -> tuple[int, bool]:
    return mark_bounds(k, count, values[k + 1], ends[0], ends[1], multipliers, SCALE, active, proposal)  # type: ignore[no-any-return]


@pytest.mark.parametrize("n", [1, 7, 64, 70])
def test_rows_and_bounds_are_marked_as_one_by_one(n: int, rng: np.random.Generator) -> None:
    rows, multipliers = rng.normal(size=(3, n)), rng.normal(size=(3, n))
    values, ends = rng.normal(size=(4, n)), np.sort(rng.normal(size=(2, n)), axis=0)
    ends[1, ::3] = np.inf
    floors = np.where(np.arange(n) % 2, -np.inf, 0.0)
    for kind in ("rows", "equalities", "bounds"):
        active, proposal = np.full((3, n), 5, dtype=np.int8), np.full((3, n), np.nan)
        if kind != "bounds":
            least = floors if kind == "equalities" else np.zeros(n)
            force = multipliers[1] + SCALE * rows[1]
            sides, expected = (force > least).astype(int), np.maximum(force, least)

            def mark(active: Sides = active, proposal: Array = proposal, least: Array = least) -> tuple[int, bool]:
                return _rows(1, rows, multipliers, active, proposal, least)

        else:
            above, below = (multipliers[1] + SCALE * (values[2] - end) for end in (ends[1], ends[0]))
            sides = (above > 0.0).astype(int) - (below < 0.0)
            expected = np.maximum(above, 0.0) + np.minimum(below, 0.0)

            def mark(active: Sides = active, proposal: Array = proposal) -> tuple[int, bool]:
                return _bounds(1, (0,) * n, values, ends, multipliers, active, proposal)

        assert mark() == (np.count_nonzero(sides), True)
        np.testing.assert_array_equal(active[1], sides)
        np.testing.assert_allclose(proposal[1], expected, rtol=1e-12, atol=1e-12)
        assert (active[[0, 2]] == 5).all() and np.isnan(proposal[[0, 2]]).all(), "the other nodes stay"
        assert mark() == (np.count_nonzero(sides), False)
        active[1, n - 1] = -active[1, n - 1] + 1
        assert mark() == (np.count_nonzero(sides), True)
