"""Vehicle and door of another size: by Froude's law the same plan, larger or smaller, slower or faster."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, VEHICLE, write_scaled

from doorman import Model, Planner, Scenario
from doorman.control.position_controller import PositionController, Setpoint
from doorman.gravity import GRAVITY
from doorman.kinematics.scale import Scale

SIZES = [0.75, 1.5]


def scaled(folder: Path, task: str, size: float) -> Model:
    """A task with every length times a size and every mass times its cube; what has a time in it, by the root of the size."""
    time = math.sqrt(size)
    plain = Scenario.load(task)
    settings = {
        "vehicle.urdf": str(write_scaled(folder / "vehicle.urdf", VEHICLE, size)),
        "door.urdf": str(write_scaled(folder / "door.urdf", DOOR, size)),
        "contact.distance_from_hinge": 0.70 * size, "contact.height": 0.80 * size,
        "planner.time_step": 0.02 * time, "planner.margin": plain.planner.margin * size,
        "simulation.torque_per_thrust": 0.016 * size,
        "vehicle.attitude_lag": plain.vehicle.attitude_lag * time,
        "limits.body_rates": tuple(rate / time for rate in plain.limits.body_rates),
    }  # fmt: skip
    if task == "paper":
        arm = [0.05, 0.1, 0.1, 0.1]
        state = (5.0, 5.0, 3.0, 9.0, 9.0 * (0.96 * time) ** 2, *arm)
        rates = [5.0 * time**2, 5.0 * time**2, 13.5 * time**2, *[10.0 * time**2] * 4]
        settings |= {"planner.weights.state": state}
        settings |= {"planner.weights.input": (0.1 / size**6, *rates)}
    return Model(Scenario.load(task, settings))


@pytest.mark.parametrize("size", SIZES)
def test_a_scaled_push_is_the_same_plan(tmp_path: Path, size: float) -> None:
    planners = [Planner(model) for model in (Model("push"), scaled(tmp_path, "push", size))]
    for planner, scale in zip(planners, (1.0, size), strict=True):
        planner.update_door(friction=0.0, disturbance=-0.5 * scale**4)  # of a hinge that resists
    plans = [planner.plan(planner.planning.start_state) for planner in planners]
    speed, rate = math.sqrt(size), 1.0 / math.sqrt(size)
    states = np.array([size] * 3 + [1.0] * 3 + [speed] * 3 + [rate] * 3 + [1.0, rate] + [1.0] * 4)
    inputs = np.array([size**3, 1.0, 1.0, size**4] + [rate] * 4)
    assert np.ptp(plans[0].states[:, 12]) > 0.01
    np.testing.assert_allclose(plans[1].states / states, plans[0].states, atol=5e-3)
    np.testing.assert_allclose(plans[1].inputs / inputs, plans[0].inputs, atol=8e-3)
    assert plans[1].cost / math.sqrt(size) == pytest.approx(plans[0].cost, rel=3e-2)


@pytest.mark.parametrize("size", SIZES)
def test_a_scaled_grip_is_the_same_plan(tmp_path: Path, size: float) -> None:
    plain, other = Model("paper"), scaled(tmp_path, "paper", size)
    plans = [Planner(model).plan(model.start_state) for model in (plain, other)]
    rate = 1.0 / math.sqrt(size)
    states, inputs = np.array([1.0] * 4 + [rate] + [1.0] * 4), np.array([size**3] + [rate] * 7)
    np.testing.assert_allclose(plans[1].states / states, plans[0].states, atol=2e-5)
    np.testing.assert_allclose(plans[1].inputs / inputs, plans[0].inputs, atol=1e-3)


@pytest.mark.parametrize("mass", [0.4, 10.0])
def test_hover_control_leans_alike_whatever_the_mass(mass: float) -> None:
    """The same error of position and velocity tilts by the same angle, and the disturbance that is learnt grows with it."""
    settings = Scenario.load("paper", {"control.max_push": 12.0 * max(mass / 3.0, 1.0)}).control
    rest = np.zeros(3)
    goal = Setpoint(np.array([0.2, -0.1, 0.05]), rest, rest, 0.3, rest, rest, np.zeros(4))
    answers = []
    for m in (3.0, mass):
        controller = PositionController(m, GRAVITY, 1.6 * m * GRAVITY, settings)
        for k in range(50):
            drift = np.array([0.001 * k, 0.0, 0.0])
            answer = controller.update(drift, np.array([0.25, 0.0, 0.0]), goal, 0.004)
        answers.append((answer.thrust / m, *answer.attitude, *(answer.disturbance / m)))
    np.testing.assert_allclose(answers[1], answers[0], rtol=1e-9)


@pytest.mark.parametrize(
    ("vehicle", "leaf", "hinge"),
    [
        (1.0, 1.0, 1.0),
        (0.1, 1.0, 1.0),
        (0.1, 0.3, 0.3),
        (4.0, 1.0, 1.0),
        (1.0, 3.0, 1.0),
        (4.0, 3.0, 3.0),
        (2.0, 3.0, 2.0),
    ],
)
def test_a_hinge_is_expected_as_of_a_room_door_unless_leaf_and_vehicle_differ_from_it_alike(
    vehicle: float, leaf: float, hinge: float
) -> None:
    door = Model(Scenario.load("push", {"door.mass": 11.0 * leaf})).door
    assert Scale(1.0, vehicle).hinge(door) == pytest.approx(hinge)
