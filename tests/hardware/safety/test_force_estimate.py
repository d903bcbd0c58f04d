"""Force of the surroundings from velocity and thrust, against motions whose force is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.hardware.pixhawk import VehicleSample
from doorman.hardware.safety.observer import FORCE_LAG, ForceEstimator
from doorman.kinematics.rotations import rotation_body_to_world

MASS = 3.0
WEIGHT = MASS * 9.81


def sample(at: float, velocity: np.ndarray, attitude: np.ndarray) -> VehicleSample:
    return VehicleSample(position_time=at, velocity=velocity, attitude=attitude)


def fly(force: np.ndarray, thrust: float, attitude: np.ndarray, duration: float, step: float = 0.01) -> list[float]:
    """Estimates along a motion under a constant force of the surroundings."""
    lift = thrust * rotation_body_to_world(attitude)[:, 2]
    acceleration = (lift + force) / MASS - np.array([0.0, 0.0, 9.81])
    estimator = ForceEstimator(MASS)
    return [estimator.update(sample(t, t * acceleration, attitude), thrust) for t in np.arange(0.0, duration, step)]


@pytest.mark.parametrize("force", [[6.0, 0.0, 0.0], [0.0, -4.0, 2.0], [0.0, 0.0, 0.0]])
@pytest.mark.parametrize("attitude", [[0.0, 0.0, 0.0], [0.1, -0.2, 1.0]])
def test_constant_force_is_found(force, attitude):
    estimates = fly(np.array(force), 1.1 * WEIGHT, np.array(attitude), 10 * FORCE_LAG)
    assert estimates[-1] == pytest.approx(np.linalg.norm(force), abs=1e-3)


def test_it_follows_with_its_lag():
    estimates = fly(np.array([10.0, 0.0, 0.0]), WEIGHT, np.zeros(3), 1.0, step=0.01)
    after_lag = estimates[round(FORCE_LAG / 0.01)]
    assert after_lag == pytest.approx(10.0 * (1.0 - math.exp(-1.0)), rel=0.02)


def test_without_thrust_nothing_is_known():
    estimator = ForceEstimator(MASS)
    for k in range(10):
        assert math.isnan(estimator.update(sample(0.01 * k, np.zeros(3), np.zeros(3)), math.nan))


def test_a_gap_forgets_what_was_before():
    estimator = ForceEstimator(MASS)
    for k in range(100):
        estimator.update(sample(0.01 * k, np.array([0.05 * k, 0.0, 0.0]), np.zeros(3)), WEIGHT)
    assert estimator.update(sample(3.0, np.zeros(3), np.zeros(3)), WEIGHT) == 0.0


def test_the_same_sample_again_changes_nothing():
    estimator = ForceEstimator(MASS)
    for k in range(50):
        last = estimator.update(sample(0.01 * k, np.array([0.02 * k, 0.0, 0.0]), np.zeros(3)), WEIGHT)
    again = [estimator.update(sample(0.49, np.array([0.98, 0.0, 0.0]), np.zeros(3)), WEIGHT) for _ in range(3)]
    assert again == [last] * 3
