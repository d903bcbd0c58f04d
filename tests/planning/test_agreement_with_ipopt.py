"""Plans against an interior-point solution of the same problem, which shares no code with them."""

from __future__ import annotations

import numpy as np
import pytest
from door_tasks import CASES, KINDS, model_of, planner_of, reference_of, start_state
from interior_point import InteriorPointReference

from doorman.model import Model
from doorman.ocp import PlanStatus
from doorman.planning.pace import time_constant_held
from doorman.planning.plan import Plan
from doorman.planning.planner import LARGEST_PRICE, Planner

PROBLEMS = [
    pytest.param(name, kind, limits, marks=[pytest.mark.slow] * (name == "seven joints"))  # kernels of an arm of its own
    for name, limits in CASES for kind in KINDS
]  # fmt: skip


def plain_cost(model: Model, plan: Plan) -> float:
    """J as in the paper, written out; weights are those of the paper's task."""
    n, dt = model.n_arm, plan.time_step
    held = 9.0 * time_constant_held(model) ** 2
    state_weights = np.array([5.0, 5.0, 3.0, 9.0, held, *([0.05] + [0.1] * n)[:n]])
    input_weights = np.array([0.1, 5.0, 5.0, 13.5, *[10.0] * n])
    cost = 0.5 * state_weights @ (plan.states[-1] - model.goal_state) ** 2
    for x, u in zip(plan.states[:-1], plan.inputs, strict=True):
        cost += 0.5 * dt * (state_weights @ (x - model.goal_state) ** 2 + input_weights @ (u - model.hover_input) ** 2)
    return float(cost)


def plain_violation(model: Model, plan: Plan, first: int = 1) -> float:
    """Largest violated constraint or limit from a node on, from the scenario's and the vehicle's numbers."""
    limits, vehicle, states, inputs = model.scenario.limits, model.vehicle, plan.states[first:], plan.inputs
    worst = (model.constraints_along(states) + model.scenario.planner.margin).max()
    if limits.enabled:
        rates = vehicle.rate_limits if limits.joint_rates is None else limits.joint_rates
        tilt = np.cos(limits.tilt) - np.cos(states[:, 0]) * np.cos(states[:, 1])
        arm, thrust = states[:, 5:], inputs[:, 0]
        beyond = [
            tilt, vehicle.lower_limits - arm, arm - vehicle.upper_limits, -thrust,
            thrust - vehicle.max_thrust, np.abs(inputs[:, 1:4]) - limits.body_rates, np.abs(inputs[:, 4:]) - rates,
        ]  # fmt: skip
        worst = max(worst, *(each.max() for each in beyond))
    return max(0.0, float(worst))


def assert_exact(model: Model, plan: Plan, state: np.ndarray) -> None:
    """It starts at the state and follows the dynamics, also when all of it is simulated from the inputs alone."""
    np.testing.assert_array_equal(plan.states[0], state)
    resimulated = [state]
    for x, u, after in zip(plan.states, plan.inputs, plan.states[1:], strict=False):
        np.testing.assert_allclose(model.step(x, u), after, atol=1e-12)
        resimulated.append(model.step(resimulated[-1], u))
    np.testing.assert_allclose(plan.states, resimulated, atol=1e-9)


@pytest.mark.parametrize(("name", "kind", "limits"), PROBLEMS)
def test_same_optimum_feasible_and_exact(name: str, kind: str, limits: bool) -> None:
    """Where IPOPT finds that there is none, as from outside and with tight limits, the plan is the way back inside."""
    model, state = model_of(name, limits), start_state(name, kind, limits)
    plan, reference = planner_of(name, limits).plan(state), reference_of(name, limits).solve(state)
    assert_exact(model, plan, state)
    assert plan.cost == pytest.approx(plain_cost(model, plan), rel=1e-12)
    assert plan.max_violation == pytest.approx(plain_violation(model, plan), abs=1e-12)
    if not reference.success:
        assert limits and plain_violation(model, plan) > 1e-3
        assert plan.status is PlanStatus.RECOVERING
        assert plain_violation(model, plan, first=plan.states.shape[0] // 2) <= 1e-6
        return
    assert plan.usable
    assert plain_violation(model, plan) <= 1e-6
    if reference.price < LARGEST_PRICE:
        assert plan.status is PlanStatus.CONVERGED
        assert plan.cost == pytest.approx(reference.cost, rel=1e-6)
        np.testing.assert_allclose(plan.states, reference.states, atol=1e-4)
    else:  # rows that cannot be held at the start: the largest price bends their optimum
        assert plan.cost < 1.001 * reference.cost


@pytest.mark.parametrize(("name", "cost"), [("paper", 15.4705225), ("coarse", 15.5157164)])
@pytest.mark.parametrize("limits", [False, True])
def test_cost_of_the_papers_start(name: str, limits: bool, cost: float) -> None:
    """The limits are wide enough for the paper's task. The cold plan stops within 2e-8 of the least cost."""
    start = model_of(name, limits).start_state
    assert planner_of(name, limits).plan(start).cost == pytest.approx(cost, rel=1e-7)
    assert reference_of(name, limits).solve(start).cost == pytest.approx(cost, rel=1e-8)


def test_a_disturbance_torque_means_the_same_to_both() -> None:
    model = model_of("coarse")
    planner = Planner(model)
    planner.update_door(disturbance=-1.5)
    reference = InteriorPointReference(model, disturbance=-1.5).solve(model.start_state)
    plan = planner.plan(model.start_state)
    assert plan.cost == pytest.approx(reference.cost, rel=1e-6)
    assert plan.cost > 1.001 * planner_of("coarse").plan(model.start_state).cost
