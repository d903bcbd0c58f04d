"""What acts at a pose's time: rotors behind their commands, the attitude of gyroscope and poses, the arm between two looks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from attitude_matrices import euler_rate_matrix

from doorman.estimation.leaf.acting import Acting
from doorman.signals import Measurement

TICK, N = 0.004, 2
ROTORS, ATTITUDE, RATES, TURNING, ARM = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12), slice(12, 14)


def attitude(time: float) -> np.ndarray:
    return np.array([0.1 * math.sin(2.0 * time), 0.15 * math.cos(time), 3.1 + 0.2 * time])


def body_rates(time: float) -> np.ndarray:
    change = (attitude(time + 1e-5) - attitude(time - 1e-5)) / 2e-5
    return np.linalg.solve(euler_rate_matrix(attitude(time)), change)


def flown(seconds: float, latency: float, noise: float = 0.0, force: float = 20.0) -> tuple[np.ndarray, float]:
    """Turns as above, with late poses; returns what acts at the last pose, and its time."""
    acting, rng = Acting(N, np.array([0.0, 0.0, 20.0]), 3.1), np.random.default_rng(4)
    for k in range(round(seconds / TICK) + 1):
        now = TICK * k
        arm, arm_rates = np.array([0.3 * now, -0.1]), np.array([0.3, 0.0])
        posed = now - latency
        seen = attitude(posed) + noise * rng.normal(size=3)
        seen[2] = math.remainder(seen[2], 2.0 * math.pi)
        rest, earlier = np.zeros(3), arm - 0.01 * arm_rates
        tick = Measurement(now, rest, rest, seen, body_rates(now), earlier, arm_rates, posed, now - 0.01)
        acting.note(tick, np.array([0.0, 0.0, force]))
        inputs = acting.at(posed, seen)
    return inputs, posed


@pytest.mark.parametrize("latency", [0.0, 0.04])
def test_attitude_rates_and_arm_are_those_of_the_poses_time(latency: float) -> None:
    inputs, time = flown(2.0, latency)
    np.testing.assert_allclose(inputs[ATTITUDE], attitude(time), atol=2e-3)
    np.testing.assert_allclose(inputs[RATES], body_rates(time - 0.01), atol=0.01)
    late = 0.03 if latency < 0.02 else 0.01
    slope = (body_rates(time - late + 0.01) - body_rates(time - late - 0.01)) / 0.02
    np.testing.assert_allclose(inputs[TURNING], slope, atol=0.05)
    np.testing.assert_allclose(inputs[ARM], [0.3 * time, -0.1], atol=1e-9)


def test_noise_of_the_poses_attitude_is_averaged_by_the_gyroscope() -> None:
    found = [flown(seconds, 0.0, noise=0.004) for seconds in (1.0, 1.2, 1.4, 1.6)]
    off = [inputs[ATTITUDE] - attitude(time) for inputs, time in found]
    assert np.sqrt(np.mean(np.square(off))) < 0.002


def test_rotors_follow_their_command_with_a_lag() -> None:
    made = [flown(seconds, 0.0, force=26.0)[0][ROTORS][2] for seconds in (0.0, 0.032, 0.3)]
    assert made == pytest.approx([20.0, 20.0 + 6.0 * (1.0 - math.exp(-0.032 / 0.03)), 26.0], abs=0.05)


def test_half_a_second_is_kept_however_long_a_flight_is() -> None:
    inputs, time = flown(12.0, 0.4)
    np.testing.assert_allclose(inputs[ATTITUDE], attitude(time), atol=2e-3)
