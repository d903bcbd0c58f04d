"""The disturbance observer against the transfer function that it is made for."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.observers.disturbance_observer import DisturbanceObserver

MASS, STEP = 3.0, 0.004


def estimates(observer: DisturbanceObserver, disturbance, duration: float, start=(1.0, -2.0, 0.5)) -> np.ndarray:
    """Estimates while a free mass obeys m p̈ = F + δ, with F chosen to cancel the estimate."""
    position, velocity, force = np.array(start), np.zeros(3), np.zeros(3)
    found = []
    for k in range(round(duration / STEP)):
        found.append(observer.update(position.copy(), force, STEP).copy())
        force = -found[-1]
        velocity = velocity + STEP * (force + disturbance(k * STEP)) / MASS
        position = position + STEP * velocity
    return np.array(found)


def test_starts_without_a_bump() -> None:
    observer = DisturbanceObserver(MASS, 5.0)
    assert observer.update(np.array([3.0, 4.0, 5.0]), np.zeros(3), 0.0) == pytest.approx(np.zeros(3))


def test_bound_and_recovery() -> None:
    observer = DisturbanceObserver(MASS, 1.0, limit=10.0)
    found = estimates(observer, lambda t: np.array([12.0 if t < 30.0 else 0.0, 0.0, 0.0]), 34.0)[:, 0]
    assert found.max() == pytest.approx(10.0)
    leaves = np.flatnonzero(found[round(30.0 / STEP) :] < 9.9)[0] * STEP
    assert leaves < 1.0  # it does not have to unwind what it gathered at the bound


@pytest.mark.parametrize("step", [0.005, 0.1, 0.2])
def test_the_bound_is_left_as_it_was_reached_however_long_the_ticks(step: float) -> None:
    rate, load = 3.0, np.array([12.0, 0.0, 0.0])
    observer = DisturbanceObserver(MASS, rate, limit=10.0)
    fixed, found = np.zeros(3), []
    for _ in range(round(10.0 / step)):  # it hovers against the load
        found.append(observer.update(fixed, -load, step)[0])
    assert max(found) == 10.0 and found[-1] == 10.0
    for _ in range(round(3.0 / step)):
        found.append(observer.update(fixed, np.zeros(3), step)[0])
    assert min(found) > -1.0
    assert abs(found[-1]) < 0.1
