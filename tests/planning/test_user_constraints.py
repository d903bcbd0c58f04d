"""Constraints and costs of the user beside a door problem's own. All share one expression, so that they compile once."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import doorman
from doorman import Planner
from doorman.exceptions import SolverError
from doorman.planning.composition import Extras
from doorman.planning.grip.door_problem import door_problem

HIGHEST = 1.32


def ceiling() -> doorman.Constraint:
    """The how-to page's."""
    return doorman.Constraint("ceiling", lambda task: task.position[2] - 1.32, unit="m")


@pytest.fixture(scope="module")
def model() -> doorman.Model:
    return doorman.Model("paper")


@pytest.fixture(scope="module")
def planner(model: doorman.Model) -> Planner:
    return Planner(model, constraints=[ceiling()])


def heights(model: doorman.Model, states: np.ndarray) -> np.ndarray:
    return np.array([model.coupling.vehicle_position(x[:3], x[3], x[5:])[2] for x in states])


def closed_loop(planner: Planner, steps: int) -> list[doorman.Plan]:
    plans = [planner.plan(planner.model.start_state)]
    for _ in range(steps):
        plans.append(planner.replan(plans[-1].states[1]))
    return plans


def test_a_plan_keeps_to_it(model: doorman.Model, planner: Planner) -> None:
    free = closed_loop(Planner(model), 100)
    assert max(heights(model, plan.states).max() for plan in free) > HIGHEST + 0.01, "it would prove nothing"
    plans = closed_loop(planner, 100)
    assert all(plan.usable for plan in plans)
    assert max(heights(model, plan.states).max() for plan in plans) <= HIGHEST + 1e-6


def test_a_violation_names_it(model: doorman.Model, planner: Planner) -> None:
    high = model.start_state.copy()
    high[5:] = [0.0, 0.5, -0.5, -1.0]  # too far for one step
    plan = planner.plan(high)
    assert not plan.usable
    assert plan.violated.startswith("ceiling [m] by 0.")


def test_numbers_of_the_scenario_compile_nothing(model: doorman.Model) -> None:
    extras = Extras.of([ceiling()], [])
    other = doorman.Model(doorman.Scenario.load("paper", {"contact.distance_from_hinge": 0.6, "planner.margin": 0.01}))
    assert type(door_problem(model, extras=extras).model) is type(door_problem(other, extras=extras).model)


def test_a_copy_plans_as_the_original(planner: Planner, model: doorman.Model) -> None:
    other = copy.deepcopy(planner)
    np.testing.assert_array_equal(other.plan(model.start_state).inputs, planner.plan(model.start_state).inputs)


def test_what_is_no_constraint_or_cost_is_refused(model: doorman.Model) -> None:
    with pytest.raises(SolverError, match="names must differ.*tilt"):
        Planner(model, constraints=[doorman.Constraint("tilt", lambda task: task.attitude[0] - 0.2)])
    with pytest.raises(SolverError, match="constraints.*doorman.Constraint"):
        Planner(model, constraints=[lambda task: task.position[2]])  # type: ignore[list-item]
    with pytest.raises(SolverError, match="costs.*doorman.Cost or doorman.Residual"):
        Planner(model, costs=[ceiling()])  # type: ignore[list-item]
    with pytest.raises(SolverError, match="not an expression"):
        Planner(model, constraints=[doorman.Constraint("ceiling", lambda task: "high")])


@pytest.mark.slow
def test_time_and_costs_are_the_users(model: doorman.Model) -> None:
    """A wall that comes down: later plans must be lower."""
    falling = doorman.Constraint("falling ceiling", lambda task: task.position[2] - (1.4 - 0.02 * task.time), unit="m")
    level = doorman.Residual("level", lambda task: task.attitude[:2], weights=50.0)
    planner = Planner(model, constraints=[falling], costs=[level])
    early = planner.plan(model.start_state)
    assert early.usable
    planner.update_time(10.0)
    late = planner.plan(model.start_state)
    limits = 1.4 - 0.02 * (10.0 + 0.02 * np.arange(51))
    assert (heights(model, late.states) <= limits + 1e-6)[1:].all() or not late.usable
    assert np.abs(early.states[:, :2]).max() < np.abs(Planner(model).plan(model.start_state).states[:, :2]).max()


@pytest.mark.slow  # each has kernels of its own
@pytest.mark.parametrize(
    ("name", "overrides"), [("push", {}), ("drawer", {}), ("hatch", {}), ("paper", {"planner.model": "lagrangian"})]
)
def test_a_row_that_is_far_away_leaves_every_plan_as_it_is(name: str, overrides: dict[str, str]) -> None:
    """It is told with its value."""
    scenario = doorman.Scenario.load(name, overrides)
    line = doorman.Constraint("line", lambda task: -10.0 - task.position[1], unit="m")
    planner, free = Planner(scenario, constraints=[line]), Planner(scenario)
    plan = planner.plan(planner.start_state)
    assert plan.usable and plan.violated == ""
    np.testing.assert_allclose(plan.states, free.plan(free.start_state).states, atol=1e-5)
    (told,) = planner.user_rows().items()
    assert told[0] == "line [m]" and told[1] < 0.0
