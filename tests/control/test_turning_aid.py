"""Turning by the door: a force along the leaf that turns the vehicle and does not move the door."""

from __future__ import annotations

import numpy as np
import pytest
from paper_door import door_normal

import doorman
from doorman.control.turning_aid import TurningAid
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.scenario import Scenario

STILL = np.zeros(3)
QUICK = 0.05
"""Lag of the attitude [s]."""


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Scenario.load("paper"))


def swung(model: Model) -> np.ndarray:
    """A vehicle whose heading lags behind a door at 25°."""
    state = model.start_state.copy()
    state[2:4] = np.radians([-42.0, 25.0])
    return state


def moment(model: Model, state: np.ndarray, force: np.ndarray) -> float:
    """About the vertical through O_B, of the leaf's reaction to a force of the tip [N m]."""
    tip = rotation_body_to_world(state[:3]) @ model.vehicle.tip_position(state[5:])
    return float(np.cross(tip, -force)[2])


@pytest.mark.parametrize("missing", [-0.2, 0.2])
def test_it_turns_the_vehicle_the_way_that_is_missing_and_leaves_the_door(model, missing) -> None:
    state = swung(model)
    force = TurningAid(model).force(state, STILL, missing, 0.005, QUICK)
    assert moment(model, state, force) * missing > 0.0
    assert force @ door_normal(state[3]) == pytest.approx(0.0, abs=1e-12)
    assert force[2] == 0.0


def test_a_vehicle_that_turns_as_planned_is_left_alone(model) -> None:
    state = swung(model)
    rates = rotation_body_to_world(state[:3]).T @ [0.0, 0.0, -0.3]  # turning about the vertical
    np.testing.assert_allclose(TurningAid(model).force(state, rates, -0.3, 0.005, QUICK), 0.0, atol=1e-3)


def test_it_grows_to_its_limit_while_the_vehicle_does_not_turn_and_fades_afterwards(model) -> None:
    state, aid = swung(model), TurningAid(model)
    first = np.linalg.norm(aid.force(state, STILL, -0.2, 0.005, QUICK))
    for _ in range(400):
        grown = np.linalg.norm(aid.force(state, STILL, -0.2, 0.005, QUICK))
    assert grown > 1.5 * first
    for _ in range(4000):
        most = np.linalg.norm(aid.force(state, STILL, -2.0, 0.005, QUICK))
    assert most == pytest.approx(0.1 * model.vehicle.mass * GRAVITY)
    for _ in range(8000):
        faded = np.linalg.norm(aid.force(state, STILL, 0.0, 0.005, QUICK))
    assert faded < 0.01


def test_where_the_leaf_points_at_the_vehicle_there_is_no_lever(model) -> None:
    state = model.start_state.copy()
    tip = rotation_body_to_world(state[:3]) @ model.vehicle.tip_position(state[5:])
    state[2] = state[2] + np.pi / 2.0 - np.arctan2(tip[1], tip[0])  # the tip is to the body as the leaf lies
    assert not TurningAid(model).force(state, STILL, 0.5, 0.005, QUICK).any()


def test_it_leaves_a_vehicle_alone_whose_attitude_is_slow(model) -> None:
    state = swung(model)
    sizes = [
        np.linalg.norm(TurningAid(model).force(state, STILL, -0.2, 0.005, lag)) for lag in (0.1, 0.18, 0.21, 0.24, 0.3)
    ]
    assert sizes == pytest.approx([sizes[0], sizes[0], 0.5 * sizes[0], 0.0, 0.0], abs=1e-9)


def test_what_was_missing_while_the_attitude_was_slow_is_not_wound_up(model) -> None:
    state, aid = swung(model), TurningAid(model)
    for _ in range(2000):
        aid.force(state, STILL, -0.2, 0.005, 0.3)
    at_rest = aid.force(state, STILL, 0.0, 0.005, QUICK)
    np.testing.assert_allclose(at_rest, 0.0, atol=1e-9)


@pytest.mark.slow
def test_a_heavy_door_with_much_friction_is_open_in_time() -> None:
    hinge = {"simulation.door_mass": 20.0, "simulation.door_damping": 0.0, "simulation.door_friction": 2.0}
    summary = doorman.simulate(Scenario.load("paper", hinge), seed=0).summary
    assert summary["time_to_open_s"] < 9.3  # without the aid it takes a second and a half longer
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0
    assert summary["collisions"] == 0 and summary["max_constraint_violation_m"] <= 0.01
