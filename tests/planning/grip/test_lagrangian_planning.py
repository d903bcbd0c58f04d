"""Plans with the full Lagrangian dynamics: the optimum that IPOPT finds, warm plans, the way to reduced states, and flights."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from attitude_matrices import body_rate_matrix
from lagrangian_in_numbers import in_numbers
from lagrangian_interior_point import LagrangianReference

from doorman import Model, Plan, Planner, PlanStatus, Scenario, simulate
from doorman.exceptions import ScenarioError
from doorman.numba_types.handles import Handle
from doorman.ocp.kernels import functions
from doorman.planning.grip.lagrangian_problem import lagrangian_numbers, lagrangian_problem
from doorman.planning.planning_model import planning_model

FULL = {"planner.model": "lagrangian"}
COARSE = {"planner.time_step": 0.05, "planner.horizon_steps": 20}
RESISTING = {"door.damping": 0.4, "door.friction": 0.3, "door.stiffness": 1.0}
TASKS: dict[str, dict[str, Any]] = {
    "paper": {},
    "coarse": {"planner.margin": 0.0, **COARSE},
    "resisting": {"contact.distance_from_hinge": 0.6, **RESISTING, **COARSE},
    "tight": {
        "planner.margin": 0.01, "limits.tilt": 0.1, "limits.body_rates": [0.5, 0.3, 0.3], "limits.joint_rates": 0.04,
        **COARSE,
    },
}  # fmt: skip


@functools.cache
def planner_of(name: str) -> Planner:
    return Planner(model_of(name))


@functools.cache
def model_of(name: str) -> Model:
    """Without a planner, whose kernels take minutes to compile."""
    return Model(Scenario.load("paper", FULL | TASKS[name]))


@functools.cache
def reference_of(name: str) -> LagrangianReference:
    return LagrangianReference(planner_of(name).model)


@pytest.fixture(scope="module", autouse=True)
def _no_solver_outlives_the_tests() -> Iterator[None]:
    yield
    planner_of.cache_clear()
    reference_of.cache_clear()


def moving_state(planner: Planner, spread: float) -> np.ndarray:
    """On the way, with body rates; attitude and posture off."""
    start = planner.planning.start_state
    way = np.array([0.0, 0.0, -0.3, -0.35, 0.0, 0.0, -0.3, -0.3])
    error = np.array([0.1, 0.1, 0.3, 0.3, 0.4, 0.4, 0.3, 0.3, *[0.15] * planner.model.n_arm])
    state: np.ndarray = start + spread * error * np.random.default_rng(11).uniform(-1.0, 1.0, len(start))
    state[:8] += way
    return state


def assert_holds(planner: Planner, plan: Plan, state: np.ndarray) -> None:
    """The plan starts at the state, obeys the full dynamics and keeps the constraints."""
    model, dynamics = planner.model, in_numbers(planner.model)
    assert plan.usable
    np.testing.assert_array_equal(plan.states[0], state)
    for x, u, after in zip(plan.states, plan.inputs, plan.states[1:], strict=False):
        np.testing.assert_allclose(dynamics.step(x, u), after, atol=1e-12)
    reduced, _ = planner.planning.reduced(plan.states, plan.inputs)
    assert (model.constraints_along(reduced[1:]) + model.scenario.planner.margin).max() <= 1e-6


CASES = [("coarse", 0.5), ("paper", None), ("coarse", None), ("coarse", 1.2), ("resisting", 0.5), ("tight", None)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "spread"), CASES)
def test_same_optimum_as_ipopt(name: str, spread: float | None) -> None:
    planner = planner_of(name)
    state = planner.planning.start_state if spread is None else moving_state(planner, spread)
    plan, reference = planner.plan(state), reference_of(name).solve(state)
    assert reference.success
    assert plan.status is PlanStatus.CONVERGED
    assert plan.cost == pytest.approx(reference.cost, rel=1e-6)
    np.testing.assert_allclose(plan.states, reference.states, atol=1e-3)
    assert_holds(planner, plan, state)


@pytest.mark.slow
def test_replans_along_the_motion_stay_near_the_optimum() -> None:
    """60 steps, one iteration each or a few more; compared with a cold plan, run to convergence."""
    planner, judge = Planner(planner_of("paper").model), planner_of("paper")
    dynamics, state = in_numbers(planner.model), planner.planning.start_state
    plan = planner.plan(state)
    for k in range(60):
        state = dynamics.step(state, plan.inputs[0])
        plan = planner.replan(state)
        assert plan.iterations <= 4
        if k % 6 == 0:
            optimum = judge.plan(state)
            assert optimum.status is PlanStatus.CONVERGED
            assert plan.cost == pytest.approx(optimum.cost, rel=1e-4)
            assert_holds(planner, plan, state)
    assert state[3] < 1.4


@numba.njit
def values(model: Any, x: Any, u: Any, after: Any, h: Any) -> None:
    functions.step(model, x, u, after)
    functions.constrain(model, x, h)


@pytest.mark.slow
def test_body_rates_keep_to_their_limits(rng: np.random.Generator) -> None:
    """Those of the body, which are not the Euler rates: with the vehicle tilted they differ by a third."""
    problem, limits = lagrangian_problem(planner_of("paper").model), planner_of("paper").model.scenario.limits
    model, names = Handle(problem.model), problem.constraint_names
    for _ in range(5):
        x = problem.cost.state_goal + 0.3 * rng.normal(size=problem.nx)
        after, h = np.empty(problem.nx), np.empty(problem.n_constraints)
        values(model, x, problem.cost.input_goal, after, h)
        rates = body_rate_matrix(x[:3]) @ x[4:7]
        for i, name in enumerate(("roll rate", "pitch rate", "yaw rate")):
            above, below = (h[names.index(f"{name} {end}")] for end in ("above", "below"))
            assert above == pytest.approx(rates[i] - limits.body_rates[i], abs=1e-13)
            assert below == pytest.approx(-rates[i] - limits.body_rates[i], abs=1e-13)
    tight = Planner(
        Model(Scenario.load("paper", FULL | {"limits.body_rates": [0.3, 0.25, 0.2], "planner.horizon_steps": 30}))
    )
    start = tight.planning.start_state.copy()
    start[3] -= 0.5
    plan = tight.plan(start)
    turning = np.array([body_rate_matrix(x[:3]) @ x[4:7] for x in plan.states[1:]])
    assert plan.usable and (np.abs(turning).max(axis=0) <= np.array([0.3, 0.25, 0.2]) + 1e-6).all()
    assert np.abs(turning[:, 2]).max() > 0.2 - 1e-6  # it matters


def test_limits_become_bounds() -> None:
    model = model_of("paper")
    bounds, limits, vehicle = lagrangian_problem(model).bounds, model.scenario.limits, model.vehicle
    np.testing.assert_array_equal(lagrangian_numbers(model)["limits.body_rates"], limits.body_rates)
    np.testing.assert_array_equal(bounds.state_lower[8:], vehicle.lower_limits)
    np.testing.assert_array_equal(bounds.input_upper, [vehicle.max_thrust, *[np.inf] * 3, *vehicle.rate_limits])
    assert np.isinf(bounds.state_lower[:8]).all()
    free = lagrangian_problem(Model(Scenario.load("paper", FULL | {"limits.enabled": False})))
    assert all(np.isinf(end).all() for end in vars(free.bounds).values())
    assert free.n_constraints == model.n_constraints + 1


def test_reduced_states_and_back(rng: np.random.Generator) -> None:
    model = model_of("paper")
    planning, m = planning_model(model), 5
    states, inputs = 0.4 * rng.normal(size=(m + 1, 8 + model.n_arm)), rng.normal(size=(m, 4 + model.n_arm))
    reduced_states, reduced_inputs = planning.reduced(states, inputs)
    np.testing.assert_array_equal(reduced_states, np.delete(states, [4, 5, 6], axis=1))
    np.testing.assert_array_equal(np.delete(reduced_inputs, [1, 2, 3], axis=1), np.delete(inputs, [1, 2, 3], axis=1))
    for k in range(m):
        rates = body_rate_matrix(states[k, :3]) @ states[k, 4:7]
        np.testing.assert_allclose(reduced_inputs[k, 1:4], rates, atol=1e-14)
        one_state, one_input = planning.reduced(states[k], inputs[k])
        np.testing.assert_array_equal(one_state, reduced_states[k])
        np.testing.assert_array_equal(one_input, reduced_inputs[k])
        np.testing.assert_allclose(planning.state(one_state, one_input[1:4]), states[k], atol=1e-14)


@pytest.mark.parametrize("kind", ["quasi_static", "lagrangian"])
def test_what_a_planning_model_says_of_itself(kind: str) -> None:
    model = Model(Scenario.load("paper", {"planner.model": kind}))
    planning = planning_model(model)
    problem = planning.problem()
    assert (len(planning.state_names), len(planning.input_names)) == (problem.nx, problem.nu)
    np.testing.assert_array_equal(problem.cost.state_goal, planning.goal_state)
    np.testing.assert_array_equal(problem.cost.input_goal, planning.hover_input)
    np.testing.assert_array_equal(planning.reduced(planning.start_state, planning.hover_input)[0], model.start_state)
    np.testing.assert_array_equal(planning.state(model.start_state, np.zeros(3)), planning.start_state)
    hovering = planning.swing(0.0)(planning.start_state, planning.hover_input)
    np.testing.assert_allclose(hovering, planning.start_state, atol=1e-12)


@pytest.mark.parametrize(("name", "length"), [("state", 9), ("input", 9)])
def test_weights_that_do_not_fit_are_an_error(name: str, length: int) -> None:
    with pytest.raises(ScenarioError) as caught:
        Planner(Scenario.load("paper", FULL | {f"planner.weights.{name}": [1.0] * length}))
    assert caught.value.field == f"planner.weights.{name}"


@pytest.mark.slow
def test_the_papers_door_is_opened() -> None:
    """A whole flight; the planner's own states are twelve, the recorded ones those of every flight."""
    model = Model(Scenario.load("paper", FULL | {"mission.start": "contact"}))
    with tempfile.TemporaryDirectory() as folder:
        recording = simulate(model, duration=12.0, path=Path(folder, "flight.mcap"))
    summary, plan = recording.summary, recording["plan"]
    assert summary is not None and summary["opened"]
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0
    assert summary["time_to_open_s"] < 8.0
    assert summary["max_constraint_violation_m"] <= 0.01
    assert summary["collisions"] == 0 and summary["min_clearance_m"] > 0.0
    assert summary["planner_rate_hz"] == pytest.approx(100.0, rel=0.01)
    assert plan["states"].shape[1:] == (51, 9) and plan["input"].shape[1:] == (8,)
    margin = model.scenario.planner.margin
    for k in range(0, len(plan.time), 40):
        assert model.constraints_along(plan["states"][k][1:]).max() <= -margin + 1e-6
