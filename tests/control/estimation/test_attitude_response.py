"""Lag of the attitude, found while it flies."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.estimation.estimator import Estimator
from doorman.control.observers.attitude_response import AttitudeResponse
from doorman.control.state_converter import StateConverter
from doorman.dynamics.attitude_loop import USUAL_LAG
from doorman.model import Model
from doorman.scenario import Scenario

TICK = 0.005


def flown(
    lag: float, duration: float, delay: float = 0.0, size: float = 0.15, turning: float = 0.0
) -> AttitudeResponse:
    """A vehicle that follows roll and pitch of a few frequencies behind a lag and a delay, while it turns [s], [rad], [rad/s]."""
    response, attitude = AttitudeResponse(), np.zeros(3)
    given = [np.zeros(3)] * (round(delay / TICK) + 1)
    for k in range(round(duration / TICK)):
        now = k * TICK
        told = size * np.array([np.sin(1.3 * now) + 0.5 * np.sin(3.1 * now), np.cos(1.7 * now), 0.0])
        given.append(told)
        euler_rates = (given.pop(0) - attitude) / lag
        euler_rates[2] = turning
        roll, pitch = attitude[:2]
        rates = np.array(
            [
                euler_rates[0] - np.sin(pitch) * euler_rates[2],
                np.cos(roll) * euler_rates[1] + np.sin(roll) * np.cos(pitch) * euler_rates[2],
                -np.sin(roll) * euler_rates[1] + np.cos(roll) * np.cos(pitch) * euler_rates[2],
            ]
        )
        response.update(told, attitude, rates, TICK)
        attitude = attitude + TICK * euler_rates
    return response


@pytest.mark.parametrize("lag", [0.08, 0.15, 0.3])
@pytest.mark.parametrize("turning", [0.0, -0.9])
def test_a_lag_is_found_within_some_seconds_also_while_it_turns(lag, turning) -> None:
    assert flown(lag, 5.0, turning=turning).lag == pytest.approx(lag, rel=0.15)


def test_a_delay_counts_as_lag() -> None:
    assert flown(0.1, 8.0, delay=0.15).lag == pytest.approx(0.25, rel=0.15)


def test_a_calm_flight_says_nothing() -> None:
    assert flown(0.4, 8.0, size=0.001).lag == pytest.approx(USUAL_LAG, abs=0.01)


def test_a_flight_begins_with_the_lag_of_the_vehicle() -> None:
    model = Model(Scenario.load("push", {"vehicle.attitude_lag": 0.2}))
    estimator = Estimator(model, StateConverter(model))
    assert estimator._response.lag == 0.2
    estimator._response.update(np.zeros(3), np.zeros(3), np.zeros(3), TICK)
    assert estimator._response.lag == pytest.approx(0.2), "it is the prior, too"
