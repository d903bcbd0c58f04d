"""One vocabulary for every planner: the names of the docs on all shipped scenarios, and rows that are written once for all."""

from __future__ import annotations

from typing import Any

import casadi as ca
import pytest

from doorman import Constraint, Model, Planner, Scenario
from doorman.exceptions import ScenarioError, SolverError
from doorman.kinematics.task import NAMES, Task
from doorman.planning.planning_model import planning_model
from doorman.resources import scenario_directory, shipped


class Looked(Exception):
    """A task was looked at; nothing is to be compiled."""


def task_of(scenario: str) -> Any:
    """The symbolic task of a scenario's planner, as a user's expression sees it."""
    seen: list[Task] = []

    def look(task: Task) -> Any:
        seen.append(task)
        raise Looked

    with pytest.raises(Looked):
        Planner(scenario, constraints=[Constraint("look", look)])
    return seen[0]


@pytest.mark.parametrize("scenario", sorted(shipped(scenario_directory(), ".toml")))
def test_every_task_has_the_names_of_the_docs(scenario: str) -> None:
    task = task_of(scenario)
    for name in NAMES:
        assert getattr(task, name) is not None, name
    assert set(NAMES) <= set(task.names())
    for number in (task.vehicle.mass, task.door.width, task.contact.height):
        assert number.is_symbolic()


@pytest.mark.parametrize(
    ("scenario", "sense"), [("paper", 1.0), ("push_left", 1.0), ("pull", 1.0), ("close", -1.0), ("drawer", 1.0)]
)
def test_opening_is_that_of_the_door(scenario: str, sense: float) -> None:
    """In the units of its joint, growing as the door opens whichever way that is, and so does its rate."""
    model, task = Model(scenario), task_of(scenario)
    expressions = [task.opening, task.opening_rate, task.joint]
    value = ca.Function("opening", [task.door_angle, task.door_rate, task.parameters], expressions)
    numbers = planning_model(model).numbers.vector
    for angle in (model.start_angle, model.goal_angle):
        opening, rate, joint = (float(each) for each in value(angle, model.goal_angle - model.start_angle, numbers))
        assert opening == pytest.approx(model.door.opening_of(angle))
        assert joint == pytest.approx(model.door.joint_value(angle))
        assert rate * sense > 0.0


@pytest.mark.parametrize("scenario", ["paper", "push"])
@pytest.mark.parametrize(
    ("wrong", "listed"), [(lambda task: task.hight, "position, "), (lambda task: task.door.hight, "height, ")]
)
def test_a_wrong_name_lists_those_that_exist(scenario: str, wrong: Any, listed: str) -> None:
    with pytest.raises(SolverError, match=f"wrong: unknown name .given 'hight'; allowed: .*{listed}"):
        Planner(scenario, constraints=[Constraint("wrong", wrong)])


@pytest.mark.parametrize(
    ("scenario", "nothing"),
    [
        ("paper", lambda task: task.side_force[0] - 2.0),  # its rotors are level
        ("push", lambda task: task.center_of_mass[2]),  # its arm has no mass
        ("drawer", lambda task: task.contact_normal[2] - task.contact_normal[0]),  # a slide turns no face
        ("hatch", lambda task: task.time - 3.0),
    ],
)
def test_a_constraint_that_nothing_changes_is_refused_at_construction(scenario: str, nothing: Any) -> None:
    with pytest.raises(SolverError, match="nothing: does not apply to this task.*allowed: .*thrust"):
        Planner(scenario, constraints=[Constraint("nothing", nothing)])


@pytest.mark.parametrize("scenario", ["pull", "drawer", "hatch"])
def test_a_lintel_is_refused_where_the_task_stays_before_the_wall(scenario: str) -> None:
    with pytest.raises(ScenarioError, match="door.frame_height"):
        Model(Scenario.load(scenario, {"door.frame_height": 1.9}))
