"""One number of the attitude loop: what plans count on is what is simulated."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.control.state_converter import LookAheads
from doorman.dynamics.attitude_loop import USUAL_LAG, AttitudeLoop
from doorman.feasibility.inputs.setup import setup_findings
from doorman.model import Model
from doorman.planning.whole_body.numbers import whole_body_numbers
from doorman.scenario import Scenario
from doorman.simulation.plant.onboard.attitude_loop import (
    USUAL_MOTOR_LAG,
    AttitudeGains,
    AttitudeParameters,
    attitude_torque,
)

LAGS = [0.05, USUAL_LAG, 0.3]


def answered(gains: AttitudeGains, motor_lag: float, wanted: float, duration: float) -> list[float]:
    """Pitch of a free body under the simulated loop after a step, at 1 kHz [rad]."""
    period, pitch, rate, torque = 0.001, 0.0, 0.0, 0.0
    loop = AttitudeParameters.of(np.diag([0.05, 0.05, 0.09]), np.full(3, 10.0), period, gains)
    desired = np.array([math.cos(0.5 * wanted), 0.0, math.sin(0.5 * wanted), 0.0])
    pitches = []
    for _ in range(round(duration / period)):
        now = np.array([math.cos(0.5 * pitch), 0.0, math.sin(0.5 * pitch), 0.0])
        attitude_torque(loop, now, np.array([0.0, rate, 0.0]), desired)
        torque += (loop.torque[1] - torque) * (period / motor_lag)
        rate += period * torque / 0.05
        pitch += period * rate
        pitches.append(pitch)
    return pitches


@pytest.mark.parametrize("lag", LAGS)
def test_the_simulated_loop_lags_by_the_number(lag: float) -> None:
    """After a step, 63 % of it is there when the lag has passed, as of a first-order lag."""
    motors = USUAL_MOTOR_LAG * lag / USUAL_LAG
    pitches = answered(AttitudeGains.of(AttitudeLoop(lag), motors), motors, 0.05, 12.0 * lag)
    passed = 0.001 * int(np.argmax(np.array(pitches) > 0.63 * 0.05))
    assert passed == pytest.approx(lag, rel=0.15)
    assert pitches[-1] == pytest.approx(0.05, rel=0.02)


def test_slow_motors_keep_the_simulated_loop_from_being_quicker() -> None:
    quick = AttitudeGains.of(AttitudeLoop(0.05), USUAL_MOTOR_LAG)
    assert quick == AttitudeGains() == AttitudeGains.of(AttitudeLoop(USUAL_LAG), USUAL_MOTOR_LAG)


@pytest.mark.parametrize("lag", [0.1, 0.2])
def test_planner_look_aheads_and_check_use_it(lag: float) -> None:
    model = Model(Scenario.load("push", {"vehicle.attitude_lag": lag}))
    numbers = whole_body_numbers(model)
    assert numbers.one("vehicle.attitude_gain") == pytest.approx(1.0 / lag)
    assert numbers.one("vehicle.rate_gain") == pytest.approx(2.8 / lag)
    ahead = LookAheads.of(model)
    assert (ahead.acceleration, ahead.attitude) == pytest.approx((1.2 * lag, 2.0 * lag))
    (found,) = [one for one in setup_findings(model) if one.name == "attitude lag"]
    assert (not found.advice) is (lag < 0.15)
