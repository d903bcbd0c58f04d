"""The lag of an attitude behind its setpoints, from signals whose lag is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.flight.watches.attitude_lag import attitude_lag


def signals(lag: float, size: float = 0.03, duration: float = 20.0) -> tuple[np.ndarray, ...]:
    random = np.random.default_rng(3)
    frequencies, phases = random.uniform(0.2, 2.0, (2, 8)), random.uniform(0.0, 6.0, (2, 8))

    def attitude(times: np.ndarray) -> np.ndarray:
        tilt = [
            size * np.sin(2.0 * np.pi * f[:, None] * times + p[:, None]).mean(axis=0)
            for f, p in zip(frequencies, phases)
        ]
        return np.column_stack([*tilt, 0.4 * times])

    asked_at, seen_at = np.arange(0.0, duration, 0.005), np.arange(0.3, duration, 0.0043)
    noise = random.normal(0.0, 0.05 * size, (len(seen_at), 3))
    return asked_at, attitude(asked_at), seen_at, attitude(seen_at - lag) + 0.02 + noise


@pytest.mark.parametrize("lag", [0.0, 0.045, 0.11, 0.22])
def test_the_lag_is_found_whatever_trim_noise_and_yaw(lag):
    assert attitude_lag(*signals(lag)) == pytest.approx(lag, abs=0.011)


def test_an_attitude_that_is_like_no_setpoint_tells_nothing():
    asked_at, asked, seen_at, seen = signals(0.1)
    noise = np.random.default_rng(5).normal(0.0, 0.03, seen.shape)
    assert math.isnan(attitude_lag(asked_at, asked, seen_at, noise))


def test_what_is_not_a_number_is_left_out():
    asked_at, asked, seen_at, seen = signals(0.1)
    seen[40:60] = math.nan
    assert attitude_lag(asked_at, asked, seen_at, seen) == pytest.approx(0.1, abs=0.011)


def test_a_calm_or_a_short_flight_tells_nothing():
    assert math.isnan(attitude_lag(*signals(0.1, size=1e-4)))
    assert math.isnan(attitude_lag(*signals(0.1, duration=4.0)))
    assert math.isnan(attitude_lag([], np.empty((0, 3)), [0.0], np.zeros((1, 3))))
