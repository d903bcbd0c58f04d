"""Velocity, gate and prediction, each against motions that are known, and their documented lag, noise and error."""

from __future__ import annotations

import math
import random

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.hardware.mocap import MocapConfig, PoseQuality
from doorman.hardware.mocap.sample import measured, nothing_yet
from doorman.hardware.mocap.tracker import TimedPose, VelocityFilter, impossible
from doorman.kinematics.quaternions import from_rotation_vector, multiply
from doorman.kinematics.rotations import quaternion_of

WINDOW = 0.05
LEVEL = (1.0, 0.0, 0.0, 0.0)
LIMITS = MocapConfig("vehicle")
rate = st.floats(-3.0, 3.0)
triples = st.tuples(rate, rate, rate)


def twist(start, velocity, body_rates, at):
    """Pose after moving with constant velocity and body rates."""
    place = tuple(v * at for v in velocity)
    return TimedPose(at, place, multiply(start, from_rotation_vector(tuple(w * at for w in body_rates))))


def along(position, duration=2.0, step=0.01):
    """Filter after a motion along x, with what it said on the way: time, velocity, lag."""
    rows, follower = [], VelocityFilter(WINDOW)
    for k in range(round(duration / step)):
        follower.add(TimedPose(k * step, (position(k * step), 0.0, 0.0), LEVEL))
        rows.append((k * step, follower.velocity[0], follower.lag))
    return rows[10:]


@given(triples, triples, triples, st.sets(st.integers(0, 12), min_size=3))
def test_constant_twists_are_found_whatever_poses_are_missing(attitude, velocity, body_rates, frames):
    follower = VelocityFilter(WINDOW)
    for frame in sorted(frames):
        follower.add(twist(quaternion_of(attitude), velocity, body_rates, 0.01 * frame))
    assert follower.velocity == pytest.approx(velocity, abs=1e-9)
    assert follower.body_rates == pytest.approx(body_rates, abs=1e-7)


def test_body_rates_are_those_of_the_body():
    follower = VelocityFilter(WINDOW)
    for k in range(6):
        follower.add(twist(quaternion_of((0.5, -0.3, 1.0)), (0.0, 0.0, 0.0), (0.0, 0.0, 2.0), 0.01 * k))
    rotation = [pin.exp3(np.array([0.0, 0.0, 2.0 * t])) for t in (0.0, 0.001)]
    assert follower.body_rates == pytest.approx(pin.log3(rotation[0].T @ rotation[1]) / 0.001, abs=1e-6)


def test_lag_is_half_the_window():
    for at, velocity, lag in along(lambda t: 0.5 * 3.0 * t * t):
        assert lag == pytest.approx(0.5 * WINDOW)
        assert velocity == pytest.approx(3.0 * (at - lag))


@pytest.mark.parametrize("frequency", [0.5, 1.0, 2.0])
def test_lag_measured_on_a_sway(frequency):
    omega = 2.0 * math.pi * frequency
    rows = np.array(along(lambda t: math.sin(omega * t), 3.0))[-200:]  # whole periods
    phases = np.exp(-1j * omega * rows[:, 0])
    measured_lag = -np.angle((rows[:, 1] * phases).sum() / (omega * np.cos(omega * rows[:, 0]) * phases).sum()) / omega
    assert measured_lag == pytest.approx(0.5 * WINDOW, rel=0.05)


def test_noise_is_as_documented():
    draw = random.Random(5)
    rows = along(lambda t: draw.gauss(0.0, 1e-4), 60.0)
    taus = np.linspace(-0.5 * WINDOW, 0.5 * WINDOW, 6)
    assert np.std([row[1] for row in rows]) == pytest.approx(1e-4 / math.sqrt((taus**2).sum()), rel=0.1)


def test_lag_after_a_gap_is_told():
    follower = VelocityFilter(WINDOW)
    for at in (0.0, 0.01, 0.02, 0.11):
        follower.add(TimedPose(at, (0.5 * at * at, 0.0, 0.0), LEVEL))
    assert follower.lag == pytest.approx(0.11 - (0.01 + 0.02 + 0.11) / 3)


@given(st.floats(0.0, 4.0), st.floats(0.0, 15.0), st.floats(0.01, 0.1))
def test_the_gate_lets_every_possible_motion_through(speed, acceleration, elapsed):
    lag = 0.025
    velocity = (speed - acceleration * lag, 0.0, 0.0)  # what the filter knows of the speed
    former = TimedPose(0.0, (0.0, 0.0, 0.0), LEVEL)
    distance = min(speed + 0.5 * acceleration * elapsed, LIMITS.max_speed) * elapsed
    pose = TimedPose(elapsed, (distance, 0.0, 0.0), quaternion_of((7.9 * elapsed, 0.0, 0.0)))
    if speed + acceleration * elapsed <= LIMITS.max_speed:
        assert impossible(LIMITS, former, pose, abs(distance - velocity[0] * elapsed), lag) == ""


@pytest.mark.parametrize(
    ("pose", "why"),
    [
        (TimedPose(0.01, (0.06, 0.0, 0.0), LEVEL), "0.060 m in 10 ms"),
        (TimedPose(0.01, (0.02, 0.0, 0.0), LEVEL), "0.020 m off its course"),
        (TimedPose(0.01, (0.0, 0.0, 0.0), quaternion_of((0.0, 0.0, 0.3))), "17° in 10 ms"),
        (TimedPose(0.01, (0.0, 0.0, 0.0), quaternion_of((math.pi, 0.0, 0.0))), "180° in 10 ms"),
        (TimedPose(0.01, (math.nan, 0.0, 0.0), LEVEL), "nan"),
    ],
)
def test_the_gate_keeps_out_what_is_impossible(pose, why):
    miss = math.hypot(*pose.position)
    assert why in impossible(LIMITS, TimedPose(0.0, (0.0, 0.0, 0.0), LEVEL), pose, miss, 0.025)


def sample(**fields):
    known = {"time": 10.0, "position": (1.0, 2.0, 3.0), "quaternion": quaternion_of((0.1, 0.2, 0.3)),
             "velocity": (0.5, 0.0, -0.5), "body_rates": (0.0, 0.0, 1.0), "frame_number": 7, "count": 3}  # fmt: skip
    return measured(**known | fields)


def test_qualities_by_age():
    ages = {0.0: "MEASURED", 0.03: "MEASURED", 0.031: "PREDICTED", 0.1: "PREDICTED", 0.101: "LOST", 1e6: "LOST"}
    found = {age: sample(time=0.0).at(age, 0.03, 0.1) for age in ages}
    assert {age: one.quality.name for age, one in found.items()} == ages
    assert all(one.fresh == (one.quality is PoseQuality.MEASURED) for one in found.values())
    assert all(one.usable == (one.quality is not PoseQuality.LOST) for one in found.values())
    assert all(one.age == pytest.approx(age) for age, one in found.items())


def test_nothing_yet_is_not_usable():
    none = nothing_yet().at(5.0, 0.03, 0.1)
    assert none.quality is PoseQuality.NONE
    assert not none.fresh
    assert not none.usable
    assert none.age == math.inf
    assert np.isnan(none.position).all()


def test_prediction_has_constant_velocity_and_body_rates():
    before = sample()
    after = before.at(10.08, 0.03, 0.1)
    assert after.time == before.time, "the stamp stays that of the measurement"
    assert after.position == pytest.approx(before.position + 0.08 * before.velocity)
    turned = pin.rpy.rpyToMatrix(0.1, 0.2, 0.3) @ pin.exp3(np.array([0.0, 0.0, 0.08]))
    assert pin.rpy.rpyToMatrix(after.attitude) == pytest.approx(turned)
    assert after.velocity == pytest.approx(before.velocity)


@pytest.mark.parametrize("acceleration", [0.5, 2.0, 5.0])
def test_prediction_error_is_bounded_as_documented(acceleration):
    """½ a T² and the velocity's lag, a λ T."""
    limit = MocapConfig("quad").prediction_limit
    omega = 2.0
    rows = along(lambda t: acceleration / omega**2 * math.sin(omega * t), 6.0)
    bound = acceleration * limit * (0.5 * limit + 0.5 * WINDOW)
    errors = []
    for at, velocity, _ in rows:
        one = sample(
            time=at, position=(acceleration / omega**2 * math.sin(omega * at), 0.0, 0.0), velocity=(velocity, 0, 0)
        )
        later = one.at(at + limit - 1e-9, 0.03, limit)
        errors.append(abs(later.position[0] - acceleration / omega**2 * math.sin(omega * (at + limit))))
    assert 0.5 * bound < max(errors) <= bound


def test_samples_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        sample().position[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        sample().at(10.05, 0.03, 0.1).attitude[0] = 1.0
