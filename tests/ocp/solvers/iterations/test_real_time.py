"""Real-time iterations: bounded work, plans near the optimum after noise, and the parts that a profile times."""

from __future__ import annotations

import numpy as np
import pytest
from door_tasks import model_of

import doorman
from doorman.ocp.solvers.replanning import EXTRA_ITERATIONS, MOST_SWEEPS

SPREAD = np.array([0.01, 0.01, 0.01, 0.01, 0.03, 0.01, 0.01, 0.01, 0.01])


@pytest.fixture(scope="module")
def planner() -> doorman.Planner:
    return doorman.Planner(model_of("paper"))


def test_noise_is_answered_with_little_work_and_near_the_optimum(planner: doorman.Planner) -> None:
    rng, judge = np.random.default_rng(5), doorman.Planner(planner.model)
    plan, gaps, sweeps = planner.plan(planner.model.start_state), [], []
    for _ in range(60):
        state = plan.states[1] + SPREAD * rng.standard_normal(9)
        plan, optimum = planner.replan(state), judge.plan(state)
        sweeps.append(planner.solver._work.result.sweeps)
        assert plan.iterations <= 1 + 2 * EXTRA_ITERATIONS
        if plan.usable and optimum.usable:
            gaps.append(plan.cost / optimum.cost - 1.0)
    assert len(gaps) >= 50
    assert max(gaps) <= 1e-3
    assert max(sweeps) <= 2 * MOST_SWEEPS + 1


def test_an_undisturbed_plan_stays_within_two_iterations_of_the_optimum(planner: doorman.Planner) -> None:
    judge, plan = doorman.Planner(planner.model), planner.plan(planner.model.start_state)
    for _ in range(40):
        plan = planner.replan(plan.states[1])
        assert plan.iterations <= 2
        assert plan.cost <= judge.plan(plan.states[0]).cost * (1.0 + 1e-5)
