"""Plans against an interior-point solution of the same problem, which shares no code with them."""

from __future__ import annotations

import numpy as np
import pytest
from door_tasks import KINDS, TASKS, model_of, planner_of, reference_of, start_state

from doorman.model import Model
from doorman.ocp import Plan, PlanStatus

PROBLEMS = [(name, kind) for name in TASKS for kind in KINDS]


def plain_cost(model: Model, plan: Plan) -> float:
    """J as in the paper, written out; weights are those of the paper's task."""
    n, dt = model.n_arm, plan.time_step
    state_weights = np.array([5.0, 5.0, 3.0, 9.0, 8.0, *([0.05] + [0.1] * n)[:n]])
    input_weights = np.array([0.1, 5.0, 5.0, 13.5, *[10.0] * n])
    cost = 0.5 * state_weights @ (plan.states[-1] - model.goal_state) ** 2
    for x, u in zip(plan.states[:-1], plan.inputs, strict=True):
        cost += 0.5 * dt * (state_weights @ (x - model.goal_state) ** 2 + input_weights @ (u - model.hover_input) ** 2)
    return float(cost)


@pytest.mark.parametrize(("name", "kind"), PROBLEMS)
def test_same_optimum_feasible_and_exact(name: str, kind: str) -> None:
    model, state = model_of(name), start_state(name, kind)
    plan, reference = planner_of(name).plan(state), reference_of(name).solve(state)
    assert reference.success
    assert plan.status is PlanStatus.CONVERGED
    assert plan.cost == pytest.approx(reference.cost, rel=1e-6)
    assert plan.cost == pytest.approx(plain_cost(model, plan), rel=1e-12)
    np.testing.assert_allclose(plan.states, reference.states, atol=1e-4)
    assert (model.constraints_along(plan.states[1:]) + model.scenario.planner.margin).max() <= 1e-6
    np.testing.assert_array_equal(plan.states[0], state)
    resimulated = [state]
    for u in plan.inputs:
        resimulated.append(model.step(resimulated[-1], u))
    np.testing.assert_allclose(plan.states, resimulated, atol=1e-9)


def test_the_problems_are_of_all_kinds() -> None:
    """Starts that violate the constraints by up to 3 cm, and optima that ride along them, are many among the above."""
    violating = active = 0
    for name, kind in PROBLEMS:
        model, state = model_of(name), start_state(name, kind)
        margin = model.scenario.planner.margin
        violating += 1e-3 < (model.constraints(state) + margin).max() <= 0.03
        nodes = model.constraints_along(planner_of(name).plan(state).states[1:]) + margin
        active += int((np.abs(nodes) < 1e-6).sum()) > 0
    assert len(PROBLEMS) >= 30
    assert violating >= 8
    assert active >= 25


@pytest.mark.parametrize(("name", "cost"), [("paper", 15.4407631), ("coarse", 15.4863841)])
def test_cost_of_the_papers_start(name: str, cost: float) -> None:
    assert planner_of(name).plan(model_of(name).start_state).cost == pytest.approx(cost, rel=1e-8)
    assert reference_of(name).solve(model_of(name).start_state).cost == pytest.approx(cost, rel=1e-8)


def test_a_disturbance_torque_means_the_same_to_both() -> None:
    from interior_point import InteriorPointReference

    from doorman.ocp import Planner

    model = model_of("coarse")
    planner = Planner(model)
    planner.update_door(disturbance=-1.5)
    reference = InteriorPointReference(model, disturbance=-1.5).solve(model.start_state)
    plan = planner.plan(model.start_state)
    assert plan.cost == pytest.approx(reference.cost, rel=1e-6)
    assert plan.cost > 1.001 * planner_of("coarse").plan(model.start_state).cost
