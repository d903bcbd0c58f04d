"""Rows of what stands beside a door, against distances in the plane and FCL."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.collision.audit import audit
from doorman.collision.rows.jambs import JAMBS
from doorman.collision.rows.plane import WALL
from doorman.model import Model
from doorman.scenario import Scenario


@pytest.fixture(scope="module")
def pulled() -> Model:
    return Model("shipped:pull")


@pytest.fixture(scope="module")
def near_latch() -> Model:
    return Model(Scenario.load("shipped:paper", {"contact.distance_from_hinge": 1.0}))


def states_of(model: Model, count: int, rng: np.random.Generator) -> np.ndarray:
    states = rng.uniform(-1.0, 1.0, (count, model.nx))
    states[:, 3] = rng.uniform(*sorted((model.travel.start, model.travel.goal)), count)
    states[:, 2] = [model.door.heading(angle) for angle in states[:, 3]] + rng.uniform(-0.8, 0.8, count)
    states[:, 4] = 0.0
    return states


def place_of(model: Model, state: np.ndarray) -> np.ndarray:
    """O_B in the doorway, from the hinge."""
    position = model.coupling.vehicle_position(state[:3], float(state[3]), state[5:])
    return np.asarray(model.door.in_doorway(position - model.door.hinge_position))


def test_a_jamb_counts_near_the_wall_alone(near_latch: Model, rng: np.random.Generator) -> None:
    assert near_latch.constraint_names[-2:] == JAMBS and near_latch.surroundings == "corners"
    door, radius = near_latch.door, near_latch.vehicle.radius
    for state in states_of(near_latch, 40, rng):
        into, along, _ = place_of(near_latch, state)
        before = max(-door.frame_depth - into, into - door.frame_back, 0.0)
        for row, beside in zip(near_latch.constraints(state)[-2:], (door.width - along, along), strict=True):
            exact = radius - math.hypot(before, max(beside, 0.0))
            assert exact - 0.004 <= row <= exact + 0.012  # rounded to the safe side, but inside of the jamb


@pytest.mark.parametrize("name", ["pulled", "near_latch"])
def test_nothing_that_the_rows_allow_collides(name: str, request: pytest.FixtureRequest) -> None:
    model = request.getfixturevalue(name)
    assert model.surroundings == "corners" or model.constraint_names[-1] == WALL
    ends = (model.travel.start, model.travel.goal)
    report = audit(model.coupling, model.constraints_along, door_angles=ends, max_tilt=0.3, draws=400_000, checks=600)
    assert report.ok, report.reason
