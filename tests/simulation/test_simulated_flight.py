"""Free flight: hover, attitude steps, moments, and the rotors' limits and lag."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.simulation import Disturbance


def settling_time(times: np.ndarray, values: np.ndarray, target: float, band: float) -> float:
    outside = np.flatnonzero(np.abs(values - target) > band * abs(target))
    return float(times[outside[-1]]) if len(outside) else 0.0


def test_hover_stays(flight):
    truths = flight(contact__kind="push", away=True).run(2.0, every=20)
    start, end = truths[0], truths[-1]
    assert np.abs(end.position - start.position).max() < 2e-3
    assert max(np.abs(truth.attitude).max() for truth in truths) < 1e-5
    assert max(np.abs(truth.arm_angles - start.arm_angles).max() for truth in truths) < 1e-4
    assert not any(truth.collisions for truth in truths)


@pytest.mark.parametrize("amplitude", [0.05, 0.2, -0.4])
@pytest.mark.parametrize("axis", [0, 1])
def test_tilt_step_settles(flight, axis, amplitude):
    vehicle = flight(contact__kind="push", away=True)
    attitude = np.zeros(3)
    attitude[axis] = amplitude
    vehicle.command(attitude=attitude)
    truths = vehicle.run(1.0, every=4)
    times, angles = np.array([t.time for t in truths]), np.array([t.attitude for t in truths])
    assert settling_time(times, angles[:, axis], amplitude, 0.05) < 0.3
    assert np.abs(angles[:, axis]).max() < 1.05 * abs(amplitude)
    assert np.abs(np.delete(angles, axis, axis=1)).max() < 1e-3


def test_yaw_step_respects_its_rate_limit_and_leaves_the_tilt(flight):
    vehicle = flight(contact__kind="push", away=True)
    vehicle.command(attitude=(0.0, 0.1, 1.2))
    truths = vehicle.run(3.0, every=4)
    assert max(abs(t.body_rates[2]) for t in truths) < 1.1
    assert truths[-1].attitude == pytest.approx([0.0, 0.1, 1.2], abs=0.01)


@pytest.mark.parametrize("axis", [0, 1])
def test_integral_takes_up_a_moment(flight, axis):
    torque = tuple(2.0 if k == axis else 0.0 for k in range(3))
    vehicle = flight(contact__kind="push", away=True, disturbance=lambda time: Disturbance(torque=torque))
    angles = np.degrees([t.attitude[axis] for t in vehicle.run(3.5, every=4)])
    assert angles.max() < 3.5
    assert abs(angles[-1]) < 0.2


@pytest.mark.parametrize(("asked", "given"), [(100.0, 48.0), (-5.0, 0.0), (20.0, 20.0)])
def test_thrust_stops_at_the_rotors_limits(flight, asked, given):
    vehicle = flight(contact__kind="push", away=True)
    vehicle.command(thrust=asked)
    before, after = vehicle.run(0.5, every=250)
    assert after.rotor_thrusts.sum() == pytest.approx(given, abs=5e-3)  # a trace of it goes to hold the attitude
    assert (after.rotor_thrusts <= 8.0).all() and (after.rotor_thrusts >= 0.0).all()
    acceleration = (after.velocity[2] - before.velocity[2]) / 0.25
    assert acceleration == pytest.approx(given / 3.0 - 9.81, abs=0.01)


@pytest.mark.parametrize("time_constant", [0.0, 0.03, 0.1])
def test_thrust_lags_by_the_time_constant(flight, time_constant):
    vehicle = flight(contact__kind="push", away=True, simulation__motor_time_constant=time_constant)
    vehicle.command(thrust=40.0)
    truths = vehicle.run(0.2, every=10)
    for truth in truths:
        passed = 1.0 - math.exp(-truth.time / time_constant) if time_constant else 1.0
        assert truth.rotor_thrusts.sum() == pytest.approx(29.43 + passed * (40.0 - 29.43), abs=2e-3)
