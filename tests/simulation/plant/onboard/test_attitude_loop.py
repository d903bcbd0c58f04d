"""The attitude loop's pieces: the split of the attitude error, the gyroscopic term and the anti-windup."""

from __future__ import annotations

import math

import numpy as np
import pinocchio
from hypothesis import given, settings
from hypothesis import strategies as st

from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.simulation.plant.onboard.attitude_loop import (
    AttitudeGains,
    AttitudeParameters,
    attitude_error,
    attitude_torque,
    integrate_rate_error,
)

angles = st.floats(-1.2, 1.2)
INERTIA = np.diag([0.045, 0.05, 0.08])


def quaternion(rotation: np.ndarray) -> np.ndarray:
    x, y, z, w = pinocchio.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])


def parameters(gains: AttitudeGains | None = None) -> AttitudeParameters:
    return AttitudeParameters.of(INERTIA, (4.0, 4.0, 0.4), 1e-3, gains)


@given(st.lists(angles, min_size=6, max_size=6))
@settings(max_examples=200, deadline=None)
def test_error_is_tilt_then_turn(values):
    now, wanted = rotation_body_to_world(values[:3]), rotation_body_to_world(values[3:])
    x, y, z = attitude_error(quaternion(now), quaternion(wanted))
    tilt = 2.0 * math.asin(min(1.0, math.hypot(x, y) / 2.0))
    axis = np.array([x, y, 0.0]) / max(math.hypot(x, y), 1e-12)
    turn = 2.0 * math.asin(max(-1.0, min(1.0, z / 2.0)))
    rebuilt = now @ pinocchio.exp3(tilt * axis) @ pinocchio.exp3(turn * np.array([0.0, 0.0, 1.0]))
    assert np.allclose(rebuilt, wanted, atol=1e-6)


def test_error_does_not_depend_on_the_quaternions_sign():
    now, wanted = (
        quaternion(rotation_body_to_world([0.1, 0.2, 3.0])),
        quaternion(rotation_body_to_world([0.0, 0.3, -3.0])),
    )
    assert np.allclose(attitude_error(now, wanted), attitude_error(now, -wanted), atol=1e-15)
    assert abs(attitude_error(now, wanted)[2]) < 0.3  # the short way round


def test_upside_down_asks_for_a_finite_tilt():
    error = attitude_error(np.array([1.0, 0, 0, 0]), np.array([0.0, 1.0, 0, 0]))
    assert np.allclose(error, [2.0, 0.0, 0.0])


def test_gyroscopic_term_cancels_that_of_the_rigid_body():
    p = parameters(AttitudeGains(rate=(0, 0, 0), integral=(0, 0, 0), derivative=(0, 0, 0)))
    rates = np.array([1.0, -2.0, 3.0])
    attitude_torque(p, np.array([1.0, 0, 0, 0]), rates, np.array([1.0, 0, 0, 0]))
    assert np.allclose(p.torque, np.cross(rates, INERTIA @ rates), atol=1e-15)


def test_integral_stands_still_in_saturation_and_is_bounded():
    p = parameters()
    attitude_torque(p, np.array([1.0, 0, 0, 0]), np.zeros(3), quaternion(rotation_body_to_world([0.1, 0.1, 0.1])))
    integrate_rate_error(p, 0.5 * p.torque)
    assert np.array_equal(p.memory.integral, np.zeros(3))
    for _ in range(100_000):
        integrate_rate_error(p, p.torque)
    assert np.allclose(p.memory.integral * np.diag(INERTIA), (4.0, 4.0, 0.4))


def test_integral_may_leave_saturation():
    p = parameters()
    attitude_torque(p, np.array([1.0, 0, 0, 0]), np.zeros(3), quaternion(rotation_body_to_world([0.1, 0.1, 0.1])))
    integrate_rate_error(p, 2.0 * p.torque)
    assert (p.memory.integral > 0.0).all()


def test_feed_forward_follows_set_points_sooner_and_answers_a_moment_alike() -> None:
    """A step of the roll, and a steady moment, on a vehicle of its inertia alone."""

    def flown(loop: AttitudeLoop, wanted: float, moment: float) -> np.ndarray:
        p, angle, rate, seen = parameters(AttitudeGains.of(loop, 0.0)), 0.0, 0.0, []
        for _ in range(300):
            half, goal = 0.5 * angle, 0.5 * wanted
            attitude_torque(
                p, np.array([np.cos(half), np.sin(half), 0.0, 0.0]), np.array([rate, 0.0, 0.0]),
                np.array([np.cos(goal), np.sin(goal), 0.0, 0.0]),
            )  # fmt: skip
            rate += 1e-3 * (p.torque[0] + moment) / INERTIA[0][0]
            angle += 1e-3 * rate
            seen.append(angle)
        return np.array(seen)

    slow, quick = AttitudeLoop(0.2), AttitudeLoop(0.05, feedback=0.2)
    half_way = [int(np.argmax(flown(loop, 0.1, 0.0) > 0.05)) for loop in (slow, quick)]
    assert half_way[1] < 0.5 * half_way[0]
    stiff = flown(AttitudeLoop(0.05), 0.0, 0.1)[-1]
    assert flown(quick, 0.0, 0.1)[-1] > 2.0 * stiff
