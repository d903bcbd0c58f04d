"""Numbers of the attitude loop: what a lag and an overshoot mean, in plans and in the simulated loop."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.control.state_converter import LookAheads
from doorman.dynamics.attitude_loop import TESTED_LAG, USUAL_LAG, AttitudeLoop
from doorman.feasibility.inputs.setup import setup_findings
from doorman.model import Model
from doorman.planning.whole_body.numbers import whole_body_numbers
from doorman.scenario import Scenario
from doorman.simulation.plant.onboard.attitude_loop import (
    AttitudeGains,
    AttitudeParameters,
    attitude_torque,
)

MOTOR_LAG = 0.03
"""Of a loop of the usual lag [s]."""
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
    motors = MOTOR_LAG * lag / USUAL_LAG
    pitches = answered(AttitudeGains.of(AttitudeLoop(lag), motors), motors, 0.05, 12.0 * lag)
    passed = 0.001 * int(np.argmax(np.array(pitches) > 0.63 * 0.05))
    assert passed == pytest.approx(lag, rel=0.15)
    assert pitches[-1] == pytest.approx(0.05, rel=0.02)


@pytest.mark.parametrize("motor_lag", [0.02, 0.05])
@pytest.mark.parametrize("lag", [0.03, 0.1, 0.25])
def test_any_motors_and_lag_make_a_loop_that_settles(lag: float, motor_lag: float) -> None:
    """A loop is tuned for its motors: quick ones of slow motors overshoot, and settle."""
    pitches = np.array(
        answered(AttitudeGains.of(AttitudeLoop(lag), motor_lag), motor_lag, 0.05, 12.0 * max(lag, 2.0 * motor_lag))
    )
    assert pitches[-1] == pytest.approx(0.05, rel=0.02)
    assert pitches.max() < 0.05 * 1.35


@pytest.mark.parametrize("overshoot", [0.05, 0.2])
def test_overshoot_of_a_step(overshoot: float) -> None:
    """By motors that add nothing; the integral adds a little."""
    gains = AttitudeGains.of(AttitudeLoop(0.2), 0.002, overshoot)
    pitches = answered(replace(gains, integral=(0.0, 0.0, 0.0)), 0.002, 0.05, 3.0)
    assert max(pitches) / 0.05 - 1.0 == pytest.approx(overshoot, abs=0.03)


@pytest.mark.parametrize("lag", [0.1, 0.28])
def test_planner_look_aheads_and_check_use_it(lag: float) -> None:
    model = Model(Scenario.load("push", {"vehicle.attitude_lag": lag}))
    numbers = whole_body_numbers(model)
    assert numbers.one("vehicle.attitude_gain") == pytest.approx(1.0 / lag)
    assert numbers.one("vehicle.rate_gain") == pytest.approx(2.8 / lag)
    dead, ahead = model.scenario.vehicle.attitude_dead_time, LookAheads.of(model.attitude_loop)
    assert (ahead.acceleration, ahead.attitude) == pytest.approx((1.2 * lag + dead, 2.0 * lag + dead))
    (found,) = [one for one in setup_findings(model) if one.name == "attitude lag"]
    assert (not found.advice) is (lag <= TESTED_LAG)


@pytest.mark.parametrize(
    ("loop", "lag", "dead_time"),
    [
        (AttitudeLoop(0.047, 0.065), 0.1, 0.065), (AttitudeLoop(0.05, 0.01), 0.1, 0.01),
        (AttitudeLoop(0.2, 0.03), 0.2, 0.03),
    ],
)  # fmt: skip
def test_a_quick_loop_is_planned_with_as_the_usual_one(loop: AttitudeLoop, lag: float, dead_time: float) -> None:
    planned = loop.planned(0.02)
    assert (planned.lag, planned.dead_time) == pytest.approx((lag, dead_time))
    assert loop.lag + loop.shaping == pytest.approx(lag)


def test_a_coarse_step_takes_lag_for_dead_time() -> None:
    planned = AttitudeLoop(0.1, 0.05).planned(0.05)
    assert planned.lag == pytest.approx(0.14) and planned.lag + planned.dead_time == pytest.approx(0.15)
    assert AttitudeLoop(0.1, 0.0).planned(0.1).dead_time == 0.0
