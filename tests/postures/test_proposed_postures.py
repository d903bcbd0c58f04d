"""Start and goal postures: the paper's where they keep all limits, what is given as given, else the widest that there is."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from postures_of import random_task, widest_of_samples, width
from urdf_variants import write_arm, write_arm_of

from doorman.model import Model
from doorman.postures.proposal import PAPER_POSTURES, follow, straight_way_is_clear
from doorman.postures.room import Room
from doorman.scenario import Scenario

KEYS = {"start.attitude", "start.arm", "goal.attitude", "goal.arm"}


def model_of(source: str = "paper", **overrides: object) -> Model:
    return Model(Scenario.load(source, {key.replace("__", "."): value for key, value in overrides.items()}))


def nearest(model: Model, state: np.ndarray) -> float:
    """Distance from constraints beyond the margin [m] and joint limits [rad], the least."""
    arm, vehicle = state[5:], model.vehicle
    inside = np.minimum(arm - vehicle.lower_limits, vehicle.upper_limits - arm)
    return min(float(inside.min()), -float(model.constraints(state).max()) - model.scenario.planner.margin)


# ---------------------------------------------------------------- what stays


def test_the_papers_postures_stay_to_the_bit() -> None:
    expected = {"start": [0.0, 0.0, 0.0, math.pi / 2, 0.0, 0.0, 1.0, -0.6, -0.4],
                "goal": [0.0, 0.0, -7 * math.pi / 18, math.pi / 9, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0]}  # fmt: skip
    for source in ("paper", "push"):
        model = model_of(source)
        np.testing.assert_array_equal(model.start_state, expected["start"])
        np.testing.assert_array_equal(model.goal_state, expected["goal"])
        assert model.proposed == PAPER_POSTURES
    np.testing.assert_array_equal(Model(Scenario()).goal_state, expected["goal"])


@pytest.mark.parametrize("degrees", [5.0, 12.0, 22.0])
def test_the_heading_follows_the_leafs_normal_where_the_papers_arm_keeps_all_limits(degrees: float) -> None:
    model = model_of(goal__door_angle=math.radians(degrees))
    assert model.proposed["goal.attitude"] == (0.0, 0.0, math.radians(degrees) - math.pi / 2)
    assert model.proposed["goal.arm"] == PAPER_POSTURES["goal.arm"]


def test_the_start_of_a_door_ajar_looks_along_its_normal(tmp_path: Path) -> None:
    arm = write_arm(tmp_path / "arm.urdf", rod=0.30)
    model = model_of(start__door_angle=1.5, vehicle__urdf=str(arm), contact__distance_from_hinge=0.6)
    assert model.proposed["start.attitude"] == (0.0, 0.0, 1.5 - math.pi / 2)
    assert model.start_state[2] == 1.5 - math.pi / 2


def test_what_is_given_is_used_as_given() -> None:
    """Even where it breaks constraints."""
    given = {"start__attitude": [0.02, -0.01, 0.1], "start__arm": [0.1, 0.9, -0.5, -0.3],
             "goal__attitude": [0.0, 0.05, -0.9], "goal__arm": [0.2, 1.0, -0.2, 0.3]}  # fmt: skip
    for source, width_of_door in (("paper", 1.2), ("push", 1.05)):
        model = model_of(source, **given, door__width=width_of_door)
        assert model.proposed == {}
        for end, state in (("start", model.start_state), ("goal", model.goal_state)):
            assert state[:3].tolist() == given[f"{end}__attitude"]
            assert state[5:].tolist() == given[f"{end}__arm"]


@pytest.mark.parametrize(("key", "value"), [
    ("goal.arm", [0.0, 1.2, -1.2, 0.0]), ("goal.attitude", [0.0, 0.0, -0.7]), ("start.arm", [0.0, 1.2, -1.1, -0.1]),
])  # fmt: skip
def test_the_rest_is_found_around_what_is_given(key: str, value: list[float]) -> None:
    model = model_of(**{"goal.door_angle": 0.9, key: value})
    assert set(model.proposed) == KEYS - {key}
    end, name = key.split(".")
    state = {"start": model.start_state, "goal": model.goal_state}[end]
    assert (state[5:] if name == "arm" else state[:3]).tolist() == value
    assert min(nearest(model, model.start_state), nearest(model, model.goal_state)) >= 0.0


# ---------------------------------------------------------------- what is found


@pytest.mark.parametrize("seed", [pytest.param(k, marks=[pytest.mark.slow] if k > 2 else []) for k in range(10)])
def test_random_tasks_get_the_widest_posture(tmp_path: Path, seed: int) -> None:
    model = random_task(tmp_path, seed)
    for name, state in (("start", model.start_state), ("goal", model.goal_state)):
        ours = width(model, state)
        assert nearest(model, state) >= -1e-9 or ours == pytest.approx(nearest(model, state), abs=1e-9)
        assert (state[:2] == 0.0).all() and state[4] == 0.0
        if model.n_arm == 4 and model.proposed[f"{name}.arm"] == PAPER_POSTURES[f"{name}.arm"]:
            continue  # the paper's stays where it keeps all limits, however near to them
        assert widest_of_samples(model, state, 20_000, ours + 0.002, seed) <= ours + 0.003


@pytest.mark.parametrize("joints", [1, 6, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 3, 5, 7))])
@pytest.mark.parametrize("degrees", [45.0, 75.0])
def test_any_arm_gets_postures_inside_all_limits(tmp_path: Path, joints: int, degrees: float) -> None:
    path = str(write_arm_of(tmp_path / "arm.urdf", joints))
    model = model_of(vehicle__urdf=path, goal__door_angle=math.radians(degrees))
    assert min(width(model, model.start_state), width(model, model.goal_state)) > 0.02
    for end, state in (("start", model.start_state), ("goal", model.goal_state)):
        assert model.proposed[f"{end}.arm"] == tuple(state[5:]) and model.proposed[f"{end}.attitude"] == tuple(
            state[:3]
        )
    room = Room(model.vehicle, model.door, model.reduced, 0.0)
    there, clear = follow(room, model.start_state, model.goal_angle)
    assert clear and straight_way_is_clear(room, there, model.goal_state)


@pytest.mark.parametrize(("distance", "goal"), [(0.45, 0.8), (0.85, 0.8), (1.0, 0.35)])
def test_any_contact_point_gets_postures_inside_all_limits(distance: float, goal: float) -> None:
    model = model_of(contact__distance_from_hinge=distance, goal__door_angle=goal)
    assert min(nearest(model, model.start_state), nearest(model, model.goal_state)) > 0.005


def test_what_was_proposed_flies_the_same_when_it_is_given() -> None:
    for source, overrides in (("paper", {"goal.door_angle": 0.785}), ("push", {"door.width": 1.1})):
        found = Model(Scenario.load(source, overrides))
        given = Model(Scenario.load(source, {**overrides, **found.proposed}))
        np.testing.assert_array_equal(given.start_state, found.start_state)
        np.testing.assert_array_equal(given.goal_state, found.goal_state)
        assert given.coupling.distance_from_hinge == found.coupling.distance_from_hinge
        assert not given.proposed
