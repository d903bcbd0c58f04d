"""The wind filter's kernels against their equations in plain numpy."""

import numpy as np
import pytest

from doorman.control.kernels.wind_step import correct_wind, predict_wind


def some(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A state and a covariance."""
    random = np.random.default_rng(seed)
    root = random.normal(0.0, 0.5, (5, 5))
    return random.normal(0.0, 1.0, 5), root @ root.T


@pytest.mark.parametrize("strength", [1.0, 0.01])
@pytest.mark.parametrize("seed", range(3))
def test_the_prediction_is_the_plain_one(seed: int, strength: float) -> None:
    (z, p), dt, noise = some(seed), 0.02, np.array([0.2, 0.2, 0.2, 0.1, 0.0])
    z[:2] *= strength
    change, (c, s) = np.eye(5), (np.cos(z[3] * dt), np.sin(z[3] * dt))
    change[:2, :2] = [[c, -s], [s, c]]
    expected = np.array([*(change[:2, :2] @ z[:2]), *z[2:]])
    if np.hypot(z[0], z[1]) > 0.15:
        change[:2, 3] = -dt * expected[1], dt * expected[0]
    covariance = change @ p @ change.T + dt * np.diag(noise)
    predict_wind(z, p, dt, 0.15, 0.2, 0.1)
    np.testing.assert_allclose(z, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(p, covariance, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_the_correction_is_the_plain_one(seed: int) -> None:
    (z, p), (x, y, up) = some(seed), np.random.default_rng(seed).normal(0.0, 1.0, 3).tolist()
    row = np.array([x, y, up, 0.0, 0.7])
    gain = p @ row / (row @ p @ row + 0.3)
    state, covariance = z + 0.4 * gain, p - np.outer(gain, p @ row)
    correct_wind(z, p, x, y, up, 0.7, 0.4, 0.3)
    np.testing.assert_allclose(z, state, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(p, covariance, rtol=1e-12, atol=1e-12)
