"""The solvers on problems that are no doors: IPOPT's local optimum from the same guess, exact dynamics, honest statuses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from car import car
from pendulum import pendulum
from point_mass import dense_solution, point_mass
from quadrotor import quadrotor
from toy import Toy

from doorman.ocp import Cddp, Hybrid, PlanStatus, Solution, Solver

TOYS = {"point mass": point_mass, "pendulum": pendulum, "car": car, "quadrotor": quadrotor}

pytestmark = pytest.mark.slow


def solved(toy: Toy, method: type[Solver]) -> Solution:
    """A solution that holds what its status says, by the toy's own equations."""
    solution = method(toy.problem).solve(toy.start)
    if solution.usable:
        assert solution.defect <= 1e-6 and solution.violation <= 1e-6
        assert toy.violation(solution.states, solution.inputs) <= 1e-6
        np.testing.assert_allclose(toy.roll_out(solution.inputs), solution.states, atol=1e-9)
        total = toy.problem.cost.total(solution.states, solution.inputs, toy.problem.time_step)
        assert solution.cost == pytest.approx(total, rel=1e-12)
    return solution


@pytest.mark.parametrize("name", TOYS)
def test_optimum_of_ipopt(name: str) -> None:
    toy = TOYS[name]()
    solution, reference = solved(toy, Hybrid), toy.reference()
    assert solution.status is PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(reference.cost, rel=1e-6)
    np.testing.assert_allclose(solution.states, reference.states, atol=5e-3)


@pytest.mark.parametrize("make", TOYS.values(), ids=TOYS)
def test_the_toys_need_their_constraints(make: Callable[[], Toy]) -> None:
    """Rows of h are active at the optimum, and inputs reach their bounds: without them these would be easy."""
    toy = make()
    reference = toy.reference()
    rows = np.array([np.array(toy.rows(x)).ravel() for x in reference.states[1:]])
    assert (rows.max(axis=0) > -1e-6).all()
    beside = np.minimum(
        reference.inputs - toy.problem.bounds.input_lower, toy.problem.bounds.input_upper - reference.inputs
    )
    assert (beside.min(axis=0) < 1e-4).any()


def test_the_point_mass_is_solved_as_by_one_dense_program() -> None:
    toy = point_mass()
    reference = dense_solution(toy)
    for method in (Hybrid, Cddp):
        solution = solved(toy, method)
        assert solution.status is PlanStatus.CONVERGED
        assert solution.cost == pytest.approx(reference.cost, rel=1e-6)
        np.testing.assert_allclose(solution.inputs, reference.inputs, atol=2e-3)


@pytest.mark.parametrize("name", ["pendulum", "car", "quadrotor"])
def test_cddp_is_honest_where_it_is_stuck(name: str) -> None:
    """Rows that take several inputs to act on: it stays feasible, and does not call its end an optimum unless it is one."""
    toy = TOYS[name]()
    solution, reference = solved(toy, Cddp), toy.reference()
    assert solution.usable
    if solution.status is PlanStatus.CONVERGED:
        assert solution.cost == pytest.approx(reference.cost, rel=1e-6)
    else:
        assert solution.status in (PlanStatus.STALLED, PlanStatus.ITERATION_LIMIT)
        assert solution.cost >= reference.cost * (1.0 - 1e-6)


@pytest.mark.parametrize("name", ["pendulum", "car", "quadrotor"])
def test_every_budget_ends_honestly(name: str) -> None:
    toy = TOYS[name]()
    solver = Hybrid(toy.problem)
    for iterations in (1, 3, 10, 30, 60):
        solution = solver.solve(toy.start, max_iterations=iterations)
        assert solution.iterations <= iterations
        if solution.usable:
            assert toy.violation(solution.states, solution.inputs) <= 1e-6
            np.testing.assert_allclose(toy.roll_out(solution.inputs), solution.states, atol=1e-9)
        else:
            assert solution.violation > 1e-6


def test_an_obstacle_in_the_start_is_named() -> None:
    """The car begins inside the first obstacle, and is driven out of it."""
    toy = car()
    solution = Hybrid(toy.problem).solve([2.2, -0.3, 0.0, 0.5])
    assert solution.status is PlanStatus.RECOVERING
    assert solution.constraint_name == "first obstacle" and "first obstacle" in solution.message()
    after = solution.states[solution.recovered_at :]
    assert max(float(np.max(np.array(toy.rows(x)))) for x in after) <= 1e-6
