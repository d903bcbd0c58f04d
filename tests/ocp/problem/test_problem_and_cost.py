"""Costs and problems: the formula, and every misuse a clear error."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from door_tasks import model_of

from doorman.exceptions import DimensionError, ScenarioError
from doorman.model import Model
from doorman.ocp import Problem, QuadraticCost
from doorman.planning.grip.door_problem import door_cost, door_numbers, door_problem
from doorman.planning.pace import time_constant_held
from doorman.scenario import Scenario

GOOD: dict[str, Any] = {
    "state_weights": [1.0, 0.0],
    "terminal_weights": [2.0, 3.0],
    "input_weights": [0.5],
    "state_goal": [1.0, -1.0],
    "input_goal": [2.0],
}


def test_cost_by_hand() -> None:
    cost = QuadraticCost(**GOOD)
    states, inputs = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, -2.0]]), np.array([[2.0], [4.0]])
    stages = 0.1 * (0.5 * 1.0 * 1.0 + 0.5 * 0.5 * 4.0)
    assert cost.total(states, inputs, 0.1) == pytest.approx(stages + 0.5 * (2.0 * 4.0 + 3.0 * 1.0), rel=1e-14)


def test_cost_is_a_frozen_copy() -> None:
    weights = np.array([1.0, 0.0])
    cost = QuadraticCost(**{**GOOD, "state_weights": weights})
    weights[0] = 7.0
    assert cost.state_weights[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        cost.state_weights[0] = 2.0


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("state_weights", [1.0]),
        ("state_weights", [1.0, -1e-9]),
        ("state_weights", [[1.0, 1.0]]),
        ("terminal_weights", [1.0, 1.0, 1.0]),
        ("terminal_weights", [1.0, math.nan]),
        ("input_weights", [-1.0]),
        ("input_weights", [1.0, 1.0]),
        ("state_goal", [math.inf, 0.0]),
        ("input_goal", 2.0),
    ],
)
def test_weights_and_goals_that_cannot_be(field: str, value: object) -> None:
    with pytest.raises(DimensionError) as caught:
        QuadraticCost(**{**GOOD, field: value})
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("field", "value"),
    [("horizon", 0), ("horizon", -3), ("time_step", 0.0), ("time_step", -0.1), ("time_step", math.nan)],
)
def test_problems_that_cannot_be(field: str, value: float) -> None:
    arguments: dict[str, Any] = {"model": None, "n_constraints": 1, "horizon": 10, "time_step": 0.1}
    with pytest.raises(DimensionError) as caught:
        Problem(**{**arguments, field: value}, cost=QuadraticCost(**GOOD))
    assert caught.value.field == field


def test_door_problem_of_the_paper() -> None:
    model = model_of("margin")
    problem = door_problem(model, door_numbers(model).replaced({"door.disturbance": 0.3}))
    assert (problem.nx, problem.nu, problem.n_constraints) == (9, 8, 7)  # six, and the tilt
    assert (problem.horizon, problem.time_step) == (50, 0.02)
    given = door_numbers(model).replaced({"limits.margin": 0.02, "door.disturbance": 0.3})
    np.testing.assert_array_equal(problem.model.parameters, given.vector)
    weights = [5.0, 5.0, 3.0, 9.0, 9.0 * 0.96**2, 0.05, 0.1, 0.1, 0.1]
    np.testing.assert_allclose(problem.cost.state_weights, weights)
    np.testing.assert_allclose(problem.cost.terminal_weights, weights)
    np.testing.assert_array_equal(problem.cost.input_weights, [0.1, 5.0, 5.0, 13.5, 10.0, 10.0, 10.0, 10.0])
    np.testing.assert_allclose(problem.cost.state_goal[:5], [0.0, 0.0, -1.2217304764, 0.3490658504, 0.0])
    np.testing.assert_allclose(problem.cost.input_goal, [29.43, *[0.0] * 7])


@pytest.mark.parametrize(("name", "joints"), [("seven joints", 7)])
def test_weights_extend_to_the_arm(name: str, joints: int) -> None:
    model = model_of(name)
    cost = door_cost(model)
    held = 9.0 * time_constant_held(model) ** 2
    np.testing.assert_allclose(cost.state_weights, [5.0, 5.0, 3.0, 9.0, held, *([0.05] + [0.1] * joints)[:joints]])
    np.testing.assert_array_equal(cost.input_weights, [0.1, 5.0, 5.0, 13.5, *[10.0] * joints])


@pytest.mark.parametrize(("name", "length", "allowed"), [("state", 8, "9"), ("input", 9, "8")])
def test_weights_that_do_not_fit_the_arm(name: str, length: int, allowed: str) -> None:
    field = f"planner.weights.{name}"
    with pytest.raises(ScenarioError, match=f"{allowed} for an arm of 4 joints") as caught:
        door_problem(Model(Scenario.load("paper", {field: [1.0] * length})))
    assert caught.value.field == field
    assert caught.value.given == length
