"""The rehearsal begins as the flight does, and goes on until the door rests."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from doorman.control.tug import TUG
from doorman.feasibility import Severity
from doorman.feasibility.mission import mission_findings
from doorman.feasibility.swing.flight import LARGEST_ERROR
from doorman.feasibility.swing.rehearsal import rehearse
from doorman.model import Model
from doorman.planning.pace import TUGGING
from doorman.scenario import Scenario
from doorman.stages import stages


def model_of(source: str = "paper", **keys: Any) -> Model:
    return Model(Scenario.load(f"shipped:{source}", {key.replace("__", "."): value for key, value in keys.items()}))


def test_a_leaf_at_its_stop_stays_there_as_its_gripper_is_tried() -> None:
    model = model_of()
    first = rehearse(model, 0.1).states[0]
    np.testing.assert_allclose(first, model.start_state, atol=1e-5)


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_a_leaf_that_stands_ajar_comes_with_the_tug(friction: float) -> None:
    """By hand: 3 kg and 5.28 kg m² are drawn against the friction at 0.7 m from the hinge."""
    model = model_of(start__door_angle=1.2, simulation__door_friction=friction)
    first = rehearse(model, 0.1).states[0]
    acceleration = (TUG * 3.0 * 9.81 * 0.7 - friction) / (5.28 + 3.0 * 0.7**2)
    assert first[4] == pytest.approx(TUGGING * acceleration, rel=2e-3)
    assert first[3] - 1.2 == pytest.approx(0.5 * TUGGING**2 * acceleration, rel=2e-3)


def test_a_tug_draws_no_leaf_beyond_its_stop() -> None:
    model = model_of(start__door_angle=0.5 * math.pi - 0.02)
    first = rehearse(model, 0.1).states[0]
    assert first[3] == pytest.approx(0.5 * math.pi, abs=1e-4) and first[4] == 0.0


def test_a_leaf_that_the_tug_draws_to_the_jamb_is_refused() -> None:
    """Flown from 30° ajar, the mission gives up at the turn, and the leaf strikes the vehicle as it leaves."""
    model = model_of(start__door_angle=1.047)
    findings = {one.name: one for one in mission_findings(model, rehearse(model))}
    assert findings["room to let go"].severity is Severity.ERROR


def test_a_plan_that_takes_its_time_is_not_cut_off() -> None:
    """Opened in flight within 20 s."""
    weights = [28.107, 10.506, 0.775, 9.874, 75.671, 0.298, 0.046, 0.023, 0.021]
    model = model_of("pull", start__opening=0.039, goal__opening=0.865, planner__weights__state=weights)
    assert abs(rehearse(model).final_door_angle - model.goal_angle) < LARGEST_ERROR


@pytest.mark.parametrize("task", ["lever_pull", "lever_push"])
def test_a_lever_is_rehearsed_to_its_goal(task: str) -> None:
    """The force on it pitches the vehicle, and is plumb as a level vehicle's: plans that know neither stop 11° short."""
    lever = stages(Scenario.load(task))[0]
    assert abs(rehearse(lever, 4.0).final_door_angle - lever.goal_angle) < math.radians(0.5)
