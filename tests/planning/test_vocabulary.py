"""One vocabulary for every planner: the names of the docs on all shipped scenarios, and rows that are written once for all."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from doorman import Constraint, Model, Planner, Scenario
from doorman.exceptions import ScenarioError, SolverError
from doorman.kinematics.task import NAMES, Task
from doorman.planning.planning_model import planning_model
from doorman.resources import scenario_directory, shipped

LINTEL = 2.0
"""Above the ground [m]."""


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


def below_lintel(task: Any) -> Any:
    """The rotor disc stays below a lintel, however it tilts."""
    up = task.rotation[2, 2]
    return task.position[2] + task.vehicle.radius * ca.sqrt(1 - up**2 + 1e-12) - LINTEL


def left_of_a_line(task: Any) -> Any:
    """A line along the world's x axis, 10 m to the right."""
    return -10.0 - task.position[1]


LINTEL_ROW = Constraint("lintel", below_lintel, unit="m")
LINE_ROW = Constraint("line", left_of_a_line, unit="m")


@pytest.mark.slow  # each has kernels of its own; a row of a user's own is planned with in test_user_constraints.py
@pytest.mark.parametrize("row", [LINTEL_ROW, LINE_ROW], ids=lambda row: row.name)
@pytest.mark.parametrize("scenario", ["paper", "push", "drawer", "hatch"])
def test_one_row_serves_every_task(scenario: str, row: Constraint) -> None:
    """A row that is far away leaves the plan as it is, and is told with its value."""
    planner, free = Planner(scenario, constraints=[row]), Planner(scenario)
    plan = planner.plan(planner.start_state)
    assert plan.usable and plan.violated == ""
    np.testing.assert_allclose(plan.states, free.plan(free.start_state).states, atol=1e-5)
    (told,) = planner.user_rows().items()
    assert told[0] == f"{row.name} [m]" and told[1] < 0.0
