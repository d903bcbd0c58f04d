"""Plant, controller and estimator of the emulated autopilot, with time made up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from autopilot_sandbox import LEVEL
from pixhawk_rig import NO

from doorman.hardware.quaternions import to_attitude
from doorman.rig.emulators.autopilot.vehicle.control import Demand, FlightController, Task, tilted
from doorman.rig.emulators.autopilot.vehicle.estimator import Estimate, Estimator
from doorman.rig.emulators.autopilot.vehicle.plant import PlantTruth, SimplePlant, thrust_axis


def test_the_simple_plant_hovers_at_its_weight_and_falls_without():
    plant = SimplePlant(mass=2.0, ground=-100.0)
    plant._position[2] = 0.0
    plant._force = plant.weight
    plant.command(plant.weight, LEVEL)
    plant.advance(1.0)
    assert np.linalg.norm(plant.truth().velocity) < 1e-9
    plant.stop_motors()
    plant.advance(1.0)
    assert plant.truth().velocity[2] < -7.0


def test_the_simple_plant_stands_on_its_ground():
    plant = SimplePlant(ground=0.3)
    plant.advance(1.0)
    assert plant.truth().on_ground and plant.truth().position[2] == 0.3


@pytest.mark.parametrize("yaw", [-2.0, 0.0, 1.0])
def test_the_simple_plant_follows_attitudes(yaw):
    plant = SimplePlant()
    plant._position[2] = 10.0
    wanted = tilted((0.2, -0.1, math.sqrt(0.95)), yaw)
    plant.command(plant.weight, wanted)
    plant.advance(2.0)
    assert abs(np.dot(plant.truth().quaternion, wanted)) == pytest.approx(1.0, abs=1e-4)


def test_tilted_attitudes_point_where_they_should():
    axis = np.array([0.3, -0.2, math.sqrt(1.0 - 0.13)])
    assert np.allclose(thrust_axis(tilted(tuple(axis), 0.7)), axis)
    assert to_attitude(tilted((0.0, 0.0, 1.0), 0.7))[2] == pytest.approx(0.7)


def test_the_controller_reaches_a_place_on_the_simple_plant():
    plant = SimplePlant()
    plant._position[2] = 1.0
    controller = FlightController(plant.weight)
    demand = Demand(Task.POSITION, position=np.array([1.0, -1.0, 2.0]), yaw=0.5)
    for _ in range(1500):
        truth = plant.truth()
        estimate = Estimate(truth.position, truth.velocity, truth.quaternion, truth.body_rates, True)
        plant.command(*controller.actuate(demand, estimate, 100.0))
        plant.advance(0.004)
    assert np.allclose(plant.truth().position, [1.0, -1.0, 2.0], atol=0.02)
    assert to_attitude(plant.truth().quaternion)[2] == pytest.approx(0.5, abs=0.01)


def standing(time: float) -> PlantTruth:
    return PlantTruth(np.array([0.1 * time, 0.0, 1.0]), np.array([0.1, 0.0, 0.0]), LEVEL, NO, False)


def test_an_estimate_by_poses_is_valid_after_some_and_drifts_away_without():
    estimator = Estimator(0.0, standing(0.0), 5.0, False, vision=True)
    now, estimate = 0.0, None
    for k in range(1000):
        now = 0.01 * k
        estimate = estimator.update(now, standing(now), 0.01)
        if k % 2 == 0 and now < 4.0:
            assert estimate.position_valid == (estimator.accepted_poses >= 10)
            estimator.pose(now, now - 0.03, standing(now - 0.03).position)
        if now == 3.9:
            assert np.linalg.norm(estimate.position - standing(now).position) < 1e-3
    assert not estimate.position_valid, "5 s after the last pose"
    drift = float(np.linalg.norm(estimate.position - standing(now).position))
    assert 0.2 < drift < 2.0


def test_poses_with_wrong_stamps_or_places_do_not_count_at_once():
    estimator = Estimator(0.0, standing(0.0), 5.0, False, vision=True)
    for k in range(100):
        now = 0.01 * k
        estimator.update(now, standing(now), 0.01)
        estimator.pose(now, now, standing(now).position)
    accepted = estimator.accepted_poses
    estimator.pose(now, now - 50.0, standing(now).position)
    estimator.pose(now, now + 5.0, standing(now).position)
    estimator.pose(now, now, standing(now).position + 3.0)
    assert estimator.accepted_poses == accepted
