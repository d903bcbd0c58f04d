"""The lintel: found in the URDF, kept below by disc and arm where they could reach it, by the same row in plan and summary."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman import Model, Planner, Scenario
from doorman.collision.rows.lintel import LINTEL
from doorman.collision.scene import CollisionScene
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.planning.composition import Extras
from doorman.planning.planning_model import planning_model
from doorman.summary.flown_constraints import flown_constraints

HIGH = {"contact.height": 1.2}
WIDE = {**HIGH, "goal.door_angle": -0.33}


@pytest.fixture(scope="module", params=["paper", "push"])
def model(request: pytest.FixtureRequest) -> Model:
    """A tip so high on the shipped door that the disc could touch the lintel."""
    return Model(Scenario.load(request.param, HIGH))


@pytest.fixture(scope="module")
def beside_jambs() -> Model:
    """The same on a way that ends behind the jamb at the hinge."""
    return Model(Scenario.load("paper", WIDE))


def states_near_the_lintel(model: Model, count: int, rng: np.random.Generator) -> np.ndarray:
    """Tilted vehicles on the contact point, with the arm hanging down so far that the body is high."""
    states = np.tile(model.start_state, (count, 1))
    states[:, :2] = rng.uniform(-0.3, 0.3, (count, 2))
    states[:, 5:] += rng.uniform(-0.6, 0.6, (count, model.n_arm))
    return states


def test_its_height_is_that_of_the_lowest_box_over_the_doorway() -> None:
    door = Model("paper").door
    assert door.frame_height == pytest.approx(1.6)  # above the sill, where the leaf begins
    assert Model(Scenario.load("paper", {"door.frame_height": 1.9})).door.frame_height == 1.9
    assert Model("drawer").door.frame_height is None and Model("hatch").door.frame_height is None


def test_only_tasks_that_could_reach_it_have_its_row(model: Model) -> None:
    assert LINTEL in model.constraint_names
    assert LINTEL not in Model("paper").constraint_names
    lowered = {"door.frame_height": 1.4}
    assert LINTEL in Model(Scenario.load("paper", lowered)).constraint_names


def test_its_row_is_the_gap_between_rim_and_lintel(model: Model, rng: np.random.Generator) -> None:
    """Against the highest of many points of the rim, and by the same row along a flight."""
    row = model.constraint_names.index(LINTEL)
    turns = np.linspace(0.0, 2.0 * math.pi, 721)
    rim = model.vehicle.radius * np.stack([np.cos(turns), np.sin(turns), 0.0 * turns], axis=1)
    for state in states_near_the_lintel(model, 20, rng):
        place = model.coupling.vehicle_position(state[:3], float(state[3]), state[5:])
        highest = (place + rim @ rotation_body_to_world(state[:3]).T)[:, 2].max()
        expected = highest - model.door.hinge_position[2] - float(model.door.frame_height or math.nan)
        assert model.constraints(state)[row] == pytest.approx(expected, abs=1e-4)
        flown = flown_constraints(model, place[None], state[None, :3], state[None, 3], state[None, 5:])
        assert flown[0, row] == pytest.approx(expected, abs=1e-4) or flown[0, row] == -math.inf


def test_beside_jambs_the_disc_is_below_it_or_outside_of_the_wall(
    beside_jambs: Model, rng: np.random.Generator
) -> None:
    """Wherever the vehicle is: what the row allows touches no lintel, and a level disc that it refuses does."""
    model, first = beside_jambs, beside_jambs.constraint_names.index(LINTEL)
    scene, door = CollisionScene(model.vehicle, model.door), model.door
    assert model.surroundings == "corners" and "tip clear of lintel" in model.constraint_names[first:]
    highest = door.hinge_position[2] + float(door.frame_height or math.nan)
    seen = {"below": 0, "before": 0, "hit": 0}
    for k in range(300):
        place = door.hinge_position + door.from_doorway(np.array([rng.uniform(-0.8, 0.8), 0.6, 0.0]))
        place[2] = highest + rng.uniform(-0.2, 0.2)
        state = model.start_state.copy()
        state[:2] = rng.uniform(-0.3, 0.3, 2) * (k % 2)
        flown = flown_constraints(model, place[None], state[None, :3], state[None, 3], state[None, 5:])[0, first:]
        hit = scene.collides(place, rotation_body_to_world(state[:3]), state[5:], float(state[3]))
        touched = [each for each in hit if "lintel" in each.second and each.distance < -1e-3]
        if flown.max() <= -1e-3:
            assert not touched
            seen["below" if place[2] < highest else "before"] += 1
        elif flown[0] > 0.01 and k % 2 == 0 and place[2] < highest + 0.07:  # where the frame's upper member is
            assert touched
            seen["hit"] += 1
    assert min(seen.values()) > 5, seen


def test_every_planner_has_the_row(model: Model, beside_jambs: Model) -> None:
    for each in (model, beside_jambs):
        names = planning_model(each).problem(Extras()).constraint_names
        assert sum(LINTEL in name for name in names) == 1


def test_a_plan_stays_below_it() -> None:
    """Where the start is below and the plan without the row would not be: by a lintel just above the start's rim."""
    free = Planner("paper")
    heights = [free.model.coupling.vehicle_position(x[:3], x[3], x[5:])[2] for x in free.plan(free.start_state).states]
    lowest = max(heights) - free.model.door.hinge_position[2] - 0.002
    planner = Planner(Scenario.load("paper", {"door.frame_height": lowest, "planner.margin": 0.0}))
    plan = planner.plan(planner.start_state)
    row = planner.model.constraint_names.index(LINTEL)
    assert plan.usable
    assert planner.model.constraints_along(plan.states[1:])[:, row].max() <= 1e-6
