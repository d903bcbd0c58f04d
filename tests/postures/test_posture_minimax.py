"""The minimax search that swings and postures share: known minimisers, bounds, and a sharp corner."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.postures.minimax import minimise_largest


def test_a_corner_of_three_planes_and_a_bowl() -> None:
    def values(z: np.ndarray) -> np.ndarray:
        return np.array([z[0] + z[1], -2.0 * z[0] + z[1], -z[1] - 1.0, 0.1 * (z @ z) - 3.0])

    def slopes(z: np.ndarray) -> np.ndarray:
        return np.array([[1.0, 1.0], [-2.0, 1.0], [0.0, -1.0], 0.2 * z])

    free = np.full(2, np.inf)
    point, largest = minimise_largest(values, slopes, np.array([2.0, 3.0]), -free, free)
    np.testing.assert_allclose(point, [0.0, -0.5], atol=1e-3)
    assert largest == pytest.approx(-0.5, abs=1e-4)


def test_bounds_are_kept() -> None:
    point, largest = minimise_largest(
        lambda z: np.array([-z[0], z[0] - 10.0]), lambda z: np.array([[-1.0], [1.0]]), np.zeros(1), np.full(1, -1.0),
        np.full(1, 2.0),
    )  # fmt: skip
    assert (point, largest) == (pytest.approx([2.0]), pytest.approx(-2.0))
