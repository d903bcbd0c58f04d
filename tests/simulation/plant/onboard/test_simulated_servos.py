"""Servos: tracking, and their limits of rate, torque and angle."""

from __future__ import annotations

import numpy as np
import pytest


def test_rates_are_tracked(flight):
    vehicle = flight(contact__kind="push", away=True)
    vehicle.command(arm_rates=[0.5, -0.4, 0.3, 0.2])
    start = vehicle.simulator.truth()
    settled, end = vehicle.run(0.6, every=300)
    assert end.arm_rates == pytest.approx([0.5, -0.4, 0.3, 0.2], abs=2e-3)
    assert end.arm_angles - settled.arm_angles == pytest.approx(0.3 * np.array([0.5, -0.4, 0.3, 0.2]), abs=1e-3)
    assert end.arm_angles - start.arm_angles == pytest.approx(0.6 * np.array([0.5, -0.4, 0.3, 0.2]), abs=1e-2)


def test_rate_limit(flight):
    vehicle = flight(contact__kind="push", away=True)
    vehicle.command(arm_rates=[50.0, 0.0, 0.0, 0.0])
    rates = [truth.arm_rates[0] for truth in vehicle.run(0.6, every=10)]
    assert rates[-1] == pytest.approx(3.1, abs=0.01)
    assert max(rates) < 3.15


@pytest.mark.parametrize(("direction", "elbow"), [(1.0, -1.2), (-1.0, 0.5)])
def test_joint_stops_at_its_limit(flight, direction, elbow):
    vehicle = flight(contact__kind="push", away=True, start__arm=(0.0, 0.0, elbow, 0.0))
    vehicle.command(arm_rates=[0.0, 0.0, 0.0, 1.5 * direction])
    truths = vehicle.run(2.0, every=10)
    angles = np.array([truth.arm_angles[3] for truth in truths]) * direction
    assert not any(truth.collisions for truth in truths)
    assert angles.max() < 1.8 + 2e-3
    assert angles[-1] == pytest.approx(1.8, abs=2e-3)
    assert truths[-1].arm_rates[3] == pytest.approx(0.0, abs=1e-3)
    vehicle.command(arm_rates=[0.0, 0.0, 0.0, -0.5 * direction])
    assert vehicle.run(0.3, every=300)[-1].arm_rates[3] == pytest.approx(-0.5 * direction, abs=5e-3)


def test_load_inside_the_torque_limit_is_held(flight):
    vehicle = flight(contact__kind="push", away=True)
    vehicle.data.qfrc_applied[vehicle.plant.arm_velocities[3]] = 2.5
    truths = vehicle.run(1.0, every=10)
    assert max(abs(truth.arm_rates[3]) for truth in truths) < 0.05
    assert abs(truths[-1].arm_rates[3]) < 1e-4
    assert truths[-1].arm_angles[3] + 0.4 == pytest.approx(2.5 / 2000.0, abs=1e-4)


def test_servo_slips_above_its_torque_limit_and_recovers(flight):
    vehicle = flight(contact__kind="push", away=True)
    joint = vehicle.plant.arm_velocities[3]
    vehicle.data.qfrc_applied[joint] = 4.0
    torques = []
    for _ in range(200):
        vehicle.simulator.advance(1)
        torques.append(vehicle.data.actuator_force[vehicle.plant.n_rotors + 3])
    assert np.abs(torques).max() < 3.1 + 1e-9
    assert vehicle.simulator.truth().arm_rates[3] > 0.5
    vehicle.data.qfrc_applied[joint] = 0.0
    assert abs(vehicle.run(0.5, every=500)[-1].arm_rates[3]) < 2e-3


def test_motion_of_a_massless_arm_does_not_move_the_vehicle(flight):
    vehicle = flight(contact__kind="push", away=True)
    start = vehicle.simulator.truth()
    vehicle.command(arm_rates=[1.0, 0.5, -0.5, 0.5])
    end = vehicle.run(0.5, every=500)[-1]
    assert np.abs(end.attitude).max() < 1e-4
    assert np.abs(end.position - start.position).max() < 1e-3
