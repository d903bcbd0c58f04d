"""Replanning any problem: the unicycle through jumps, wrong times and new parameters."""

from __future__ import annotations

import math

import numpy as np
import pytest
import unicycle

from doorman import ocp
from doorman.exceptions import DimensionError

pytestmark = pytest.mark.slow  # its solver takes a minute to compile


@pytest.fixture(scope="module")
def problem() -> ocp.Problem:
    return unicycle.problem()


def test_without_a_trajectory_it_solves(problem: ocp.Problem) -> None:
    solver = ocp.Hybrid(problem)
    status, _ = solver.replan(unicycle.START)
    assert status is ocp.PlanStatus.CONVERGED
    assert solver.cost == ocp.Hybrid(problem).solve(unicycle.START).cost


def test_following_with_the_right_time_stays_near_the_optimum(problem: ocp.Problem) -> None:
    solver = ocp.Hybrid(problem)
    state = unicycle.START
    for k in range(8):
        at = unicycle.nodes(first=k)
        solver.update_parameters(node_parameters=at)
        status, _ = solver.replan(state, elapsed=unicycle.TIME_STEP)
        states, inputs = solver.trajectory()
        best, _ = unicycle.ipopt((states, inputs), at=at, start=state)  # on this side of the obstacle
        assert status.usable
        assert solver.cost <= best * (1.0 + 1e-2)
        state = states[1].copy()


def test_after_jumps_and_wrong_times_it_comes_to_an_optimum(problem: ocp.Problem) -> None:
    random = np.random.default_rng(5)
    solver = ocp.Hybrid(problem)
    solver.replan(unicycle.START)
    for elapsed in (0.0, 0.7, 4.0, 100.0, -1.0, None):
        state = np.array([*random.uniform([-0.5, -0.5], [0.5, 0.5]), random.uniform(-1.0, 1.0)])
        status, _ = solver.replan(state, elapsed)
        assert status.usable
        for _ in range(5):
            solver.replan(state, elapsed=0.0)
        best, _ = unicycle.ipopt(solver.trajectory(), start=state)
        assert solver.cost <= best * (1.0 + 1e-3)


def test_new_parameters_are_followed(problem: ocp.Problem) -> None:
    solver = ocp.Hybrid(problem)
    solver.replan(unicycle.START)
    solver.update_parameters([0.6, 2.0], unicycle.nodes(speed=0.0))
    status, _ = solver.replan(unicycle.START, elapsed=0.0)
    states = solver.trajectory()[0]
    distance = np.hypot(*(states[1:, :2] - unicycle.nodes(speed=0.0)[1:, :2]).T).min()
    assert status.usable and distance > 0.6 - 1e-5


@pytest.mark.parametrize("bad", [{"elapsed": math.nan}, {"max_iterations": 0}, {"time_limit": 0.0}])
def test_bad_times_and_budgets_are_refused(problem: ocp.Problem, bad: dict[str, float]) -> None:
    solver = ocp.Hybrid(problem)
    with pytest.raises(DimensionError):
        solver.replan(unicycle.START, **bad)
    with pytest.raises(DimensionError):
        solver.replan([np.nan, 0.0, 0.0])
