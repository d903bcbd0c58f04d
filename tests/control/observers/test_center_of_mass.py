"""The observer of a vehicle whose centre of mass is beside O_B: turning is no outer force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from urdf_variants import VEHICLE, write_massive

from doorman.control.center_of_mass import center_of_mass
from doorman.control.observers.vehicle_observer import AT_THE_ORIGIN, VehicleObserver
from doorman.kinematics.rotations import euler_rate_matrix, rotation_body_to_world
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.signals import Measurement

STEP = 0.004


@pytest.fixture(scope="module")
def massive(tmp_path_factory: pytest.TempPathFactory) -> Vehicle:
    """0.6 kg on the arm."""
    path = tmp_path_factory.mktemp("urdf") / "arm.urdf"
    return Vehicle(write_massive(path, {"servo_2": 0.2, "servo_3": 0.2, "servo_4": 0.2}))


def nodding(vehicle: Vehicle, time: float, center: np.ndarray) -> Measurement:
    """A vehicle that pitches and yaws about its resting centre of mass while the arm moves."""
    phase = 5.0 * time
    attitude = np.array([0.0, 0.1 * math.sin(phase), 0.2 * math.sin(phase)])
    rates = 5.0 * np.array([0.0, 0.1, 0.2]) * math.cos(phase)
    arm, arm_rates = np.array([0.0, 1.0, -0.6, -0.4]) + 0.1 * math.sin(phase), np.full(4, 0.5 * math.cos(phase))
    place = center - rotation_body_to_world(attitude) @ vehicle.center_of_mass(arm)
    body_rates = np.linalg.solve(euler_rate_matrix(attitude), rates)
    return Measurement(time, place, np.zeros(3), attitude, body_rates, arm, arm_rates, time)


def test_place_and_velocity_follow_attitude_and_arm(massive: Vehicle) -> None:
    center = np.array([1.0, 2.0, 1.5])
    now = nodding(massive, 0.3, center)
    place, velocity = center_of_mass(massive, now)
    np.testing.assert_allclose(now.position + place, center, atol=1e-13)
    before, after = (nodding(massive, 0.3 + change, center).position for change in (-1e-5, 1e-5))
    np.testing.assert_allclose((after - before) / 2e-5, -velocity, atol=1e-6)


def test_turning_about_the_centre_of_mass_is_no_outer_force(massive: Vehicle) -> None:
    aware, unaware = VehicleObserver(massive.mass, 15.0), VehicleObserver(massive.mass, 15.0)
    felt, center = [], np.array([0.0, 0.0, 1.0])
    for k in range(500):
        now = nodding(massive, k * STEP, center)
        for observer, about in ((aware, center_of_mass(massive, now)), (unaware, AT_THE_ORIGIN)):
            observer.update(now.position, now.time, now.time, np.zeros(3), STEP, about)
        np.testing.assert_allclose(aware.position, now.position, atol=1e-12)
        felt.append([np.abs(aware.outer_force).max(), np.abs(unaware.outer_force).max()])
    worst = np.max(felt, axis=0)
    assert worst[0] < 1e-9 and worst[1] > 0.2


def test_an_arm_without_mass_changes_nothing() -> None:
    assert center_of_mass(Vehicle(VEHICLE), nodding(Vehicle(VEHICLE), 0.1, np.zeros(3))) is AT_THE_ORIGIN
