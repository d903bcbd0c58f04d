"""CDDP on the door problem: optimality conditions, feasible iterates, ProxQP as the guess's plain twin, statuses."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest
from door_tasks import model_of, planner_of, start_state

from doorman.exceptions import DimensionError
from doorman.model import Model
from doorman.ocp import Cddp, CddpOptions, PlanStatus, Solution
from doorman.ocp.door_problem import door_problem

TIMES = ("solve_time",)
RIDING = [("paper", "active"), ("paper", "violating"), ("margin", "thrown"), ("rod", "thrown")]
"""Problems whose optimum rides along constraints."""


@pytest.fixture(scope="module")
def solver() -> Cddp:
    return Cddp(door_problem(model_of("paper")))


@pytest.fixture(scope="module")
def hover() -> np.ndarray:
    return np.tile(model_of("paper").hover_input, (50, 1))


def solve_cold(name: str, state: np.ndarray, options: CddpOptions | None = None) -> tuple[Solution, Cddp]:
    model = model_of(name)
    solver = Cddp(door_problem(model), options)
    hover = np.tile(model.hover_input, (model.scenario.planner.horizon_steps, 1))
    return solver.solve(state, hover, 200, accelerate=True), solver


def lagrangian(model: Model, state: np.ndarray, inputs: np.ndarray, multipliers: np.ndarray) -> float:
    """J + Σ λᵀ(h + margin) along the rollout of the inputs."""
    states = [state]
    for u in inputs:
        states.append(model.step(states[-1], u))
    x, problem = np.array(states), door_problem(model)
    h = model.constraints_along(x[1:]) + model.scenario.planner.margin
    return problem.cost.total(x, inputs, problem.time_step) + float((multipliers * h).sum())


@pytest.mark.parametrize(("name", "kind"), [("coarse", "active"), ("coarse", "thrown"), ("rod", "violating")])
def test_optimality_conditions(name: str, kind: str) -> None:
    """Multipliers are not negative and complementary; the Lagrangian's gradient by the inputs vanishes."""
    model, state = model_of(name), start_state(name, kind)
    solution, _ = solve_cold(name, state, CddpOptions(tolerance=1e-14))
    assert solution.status is PlanStatus.CONVERGED
    h = model.constraints_along(solution.states[1:]) + model.scenario.planner.margin
    assert h.max() <= 1e-9
    assert (solution.multipliers >= 0.0).all()
    assert (solution.multipliers > 1e-3).sum() >= 2
    np.testing.assert_allclose(solution.multipliers * h, 0.0, atol=1e-7)
    inputs, zero = solution.inputs.copy(), np.zeros_like(solution.multipliers)
    gradient, unconstrained = np.empty(inputs.shape), np.empty(inputs.shape)
    for at in np.ndindex(inputs.shape):
        for multipliers, out in ((solution.multipliers, gradient), (zero, unconstrained)):
            sides = []
            for step in (1e-5, -1e-5):
                moved = inputs.copy()
                moved[at] += step
                sides.append(lagrangian(model, state, moved, multipliers))
            out[at] = (sides[0] - sides[1]) / 2e-5
    assert np.abs(unconstrained).max() > 0.02
    np.testing.assert_allclose(gradient, 0.0, atol=1e-6)
    assert solution.stationarity < 1e-6


@pytest.mark.parametrize(("name", "kind"), RIDING)
def test_proxqp_at_every_node_gives_the_same_plan(name: str, kind: str) -> None:
    state = start_state(name, kind)
    guessed, guessing = solve_cold(name, state)
    plain, asking = solve_cold(name, state, CddpOptions(guess_active_sets=False))
    assert asking.quadratic_programs > 20
    assert guessing.quadratic_programs < asking.quadratic_programs / 10
    assert plain.status is guessed.status is PlanStatus.CONVERGED
    assert plain.cost == pytest.approx(guessed.cost, rel=1e-8)
    assert plain.max_violation <= 1e-9
    np.testing.assert_allclose(plain.states, guessed.states, atol=1e-4)
    np.testing.assert_allclose(plain.inputs, guessed.inputs, atol=1e-3)


@pytest.mark.parametrize("kind", ["scenario", "active", "violating", "thrown"])
@pytest.mark.parametrize("accelerate", [False, True])
def test_every_iterate_is_feasible_and_none_is_dearer(
    solver: Cddp, hover: np.ndarray, kind: str, accelerate: bool
) -> None:
    model, state = model_of("paper"), start_state("paper", kind)
    costs = []
    for iterations in range(31):
        solution = solver.solve(state, hover, iterations, accelerate=accelerate)
        assert solution.status.usable
        assert solution.max_violation <= 1e-9
        assert model.constraints_along(solution.states[1:]).max() <= 1e-9
        for x, u, after in zip(solution.states, solution.inputs, solution.states[1:], strict=False):
            np.testing.assert_allclose(model.step(x, u), after, atol=1e-12)
        costs.append(solution.cost)
        if solution.status is PlanStatus.CONVERGED:
            break
        assert solution.status is PlanStatus.ITERATION_LIMIT
        assert solution.iterations == iterations or accelerate
    assert solution.status is PlanStatus.CONVERGED
    assert (np.diff(costs) <= 1e-10).all()
    assert costs[0] > 1.01 * costs[-1] or accelerate
    assert costs[-1] == pytest.approx(planner_of("paper").plan(state).cost, rel=1e-8)


@pytest.mark.parametrize("name", ["paper", "margin"])
def test_acceleration_finds_the_active_set_in_fewer_iterations(name: str) -> None:
    """From the scenario's start the rollout rides along the doorframe, and CDDP alone leaves it node by node."""
    model = model_of(name)
    solver, hover = Cddp(door_problem(model)), np.tile(model.hover_input, (50, 1))
    plain, fast = (solver.solve(model.start_state, hover, 200, accelerate=accelerate) for accelerate in (False, True))
    assert fast.cost == pytest.approx(plain.cost, rel=1e-8)
    assert fast.iterations <= plain.iterations / 2


def test_the_same_bits_every_time(hover: np.ndarray) -> None:
    """A second solver, and the first one again with other solves between, even failed ones."""
    model, state = model_of("paper"), start_state("paper", "violating")
    first, second = Cddp(door_problem(model)), Cddp(door_problem(model))
    lost = model.start_state.copy()
    lost[4] = 1e9
    solutions = [solver.solve(state, hover, 6, accelerate=True) for solver in (first, second)]
    failures = [second.solve(lost, hover, 6)]
    second.solve(start_state("paper", "late"), hover, 20)
    failures.append(second.solve(lost, hover, 6))
    solutions.append(second.solve(state, hover, 6, accelerate=True))
    for one, other in ((solutions[0], solutions[1]), (solutions[0], solutions[2]), (failures[0], failures[1])):
        for field in fields(Solution):
            if field.name not in TIMES:
                np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name), field.name)


def test_feedback_is_nearly_optimal_from_a_neighbouring_state(solver: Cddp, hover: np.ndarray) -> None:
    model, state = model_of("paper"), start_state("paper", "moving")
    solution = solver.solve(state, hover, 200, accelerate=True)
    push = 1e-3 * np.sin(np.arange(9.0) + 1.0)
    optimum = solver.solve(state + push, hover, 200, accelerate=True).cost
    lost = []
    for feedback in (0.0, 1.0):
        states, inputs = [state + push], []
        for u, gain, planned in zip(solution.inputs, solution.gains, solution.states, strict=False):
            inputs.append(u + feedback * gain @ (states[-1] - planned))
            states.append(model.step(states[-1], inputs[-1]))
        lost.append(solver.problem.cost.total(np.array(states), np.array(inputs), 0.02) - optimum)
    assert lost[0] > 1e-3
    assert abs(lost[1]) < 0.01 * lost[0]


@pytest.mark.parametrize(("entry", "value"), [(2, -3.0), (2, 2.0), (3, 3.0), (7, 1.5)])
def test_no_way_inside_is_infeasible_and_says_where(solver: Cddp, hover: np.ndarray, entry: int, value: float) -> None:
    """Turned away, behind the leaf, or the arm above the body: one step's inputs cannot bring the next state inside."""
    state = model_of("paper").start_state.copy()
    state[entry] = value
    for accelerate in (False, True):
        solution = solver.solve(state, hover, 50, accelerate=accelerate)
        assert solution.status is PlanStatus.INFEASIBLE
        assert not solution.status.usable
        assert solution.cost == solution.stationarity == math.inf
        assert 1e-3 < solution.max_violation < math.inf
        assert np.isfinite(solution.states[: solution.worst_node]).all()
        assert np.isnan(solution.states[solution.worst_node + 1 :]).all()
        assert np.isnan(solution.inputs[solution.worst_node :]).all()
        assert (solution.multipliers == 0.0).all() or accelerate


def test_numbers_out_of_hand_are_diverged(solver: Cddp, hover: np.ndarray) -> None:
    state = model_of("paper").start_state.copy()
    state[4] = 1e9
    solution = solver.solve(state, hover, 50, accelerate=True)
    assert solution.status is PlanStatus.DIVERGED
    assert not solution.status.usable
    assert solution.cost == solution.max_violation == solution.stationarity == math.inf


def test_only_solutions_that_hold_are_usable() -> None:
    usable = {status for status in PlanStatus if status.usable}
    assert usable == {PlanStatus.CONVERGED, PlanStatus.ITERATION_LIMIT, PlanStatus.STALLED}


def test_results_cannot_be_written_to(solver: Cddp, hover: np.ndarray) -> None:
    solution = solver.solve(start_state("paper", "active"), hover, 3)
    for name in ("states", "inputs", "gains", "multipliers"):
        array = getattr(solution, name)
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
        kept = array.copy()
        solver.solve(start_state("paper", "late"), hover, 3)
        np.testing.assert_array_equal(array, kept)


def test_wrong_guesses_are_errors(solver: Cddp, hover: np.ndarray) -> None:
    state = model_of("paper").start_state
    with pytest.raises(DimensionError, match="state"):
        solver.solve(state[:8], hover, 5)
    with pytest.raises(DimensionError, match=r"inputs.*\(49, 8\)"):
        solver.solve(state, hover[:49], 5)
    with pytest.raises(DimensionError, match="inputs"):
        solver.solve(state, np.full((50, 8), np.nan), 5)
    for name, array in (
        ("nominal_states", np.zeros((50, 9))),
        ("nominal_states", np.full((51, 9), np.inf)),
        ("gains", np.zeros((50, 9, 8))),
        ("active", np.zeros((50, 5), dtype=bool)),
    ):
        with pytest.raises(DimensionError, match=name):
            solver.solve(state, hover, 5, **{name: array})
    with pytest.raises(DimensionError, match="another type of model"):
        solver.update_model((1.0, 2.0))
