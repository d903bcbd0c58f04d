"""The solvers on a cart's tasks: IPOPT's optimum, statuses, budgets, warm starts, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from double_integrator import Variant

from doorman.exceptions import DimensionError, SolverError
from doorman.ocp import Cddp, Hybrid, PlanStatus, Solver, SolverOptions
from doorman.ocp.solvers.options import HESSIANS, Hessian
from doorman.ocp.solvers.replanning import EXTRA_ITERATIONS

TASKS = {
    "free": Variant(),
    "wall": Variant(start=(0.0, 0.2, 0.0), wall=0.8),
    "speed": Variant(start=(-0.3, 0.1, 0.0), speed=0.5),
    "mixed": Variant(start=(0.0, 0.0, 0.0), power=0.7),
    "end": Variant(start=(-0.2, 0.0, 0.0), dock=0.9),
    "bounds": Variant(start=(0.1, 0.0, 0.0), force=(-0.7, 0.8), rate=(-0.1, 0.15), boom=(-0.1, 0.3)),
    "all": Variant(
        start=(0.0, 0.1, 0.0), wall=0.9, reach=0.2, speed=0.6, power=0.9, force=(-0.9, 0.8), rate=(-0.1, 0.2)
    ),
    "bent": Variant(start=(0.0, 0.0, 0.0), bend=0.5, speed=0.6, force=(-0.8, 0.8)),
}


def checked(variant: Variant, solver: Solver, feasibility: float = 1e-6):
    solution = solver.solve(variant.start)
    assert solution.defect <= 1e-6
    assert variant.violation(solution.states, solution.inputs) <= feasibility
    assert variant.defect(solution.states, solution.inputs) <= 1e-6
    return solution


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("hessian", HESSIANS)
def test_optimum_of_ipopt(name: str, hessian: Hessian) -> None:
    variant = TASKS[name]
    solver = Hybrid(variant.problem(), SolverOptions(hessian=hessian))
    solution, reference = checked(variant, solver), variant.reference()
    assert solution.status is PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(reference.cost, rel=1e-6)
    np.testing.assert_allclose(solution.states, reference.states, atol=2e-3)
    assert solution.kkt_residual < 1e-3
    assert not solution.states.flags.writeable and not solution.inputs.flags.writeable


@pytest.mark.parametrize("guess", [True, False])
@pytest.mark.parametrize("name", ["free", "speed", "mixed", "bounds", "bent"])
def test_cddp_alone_reaches_it_where_one_input_suffices(name: str, guess: bool) -> None:
    """Rows of relative degree one; without guesses every program goes to ProxQP."""
    variant = TASKS[name]
    solver = Cddp(variant.problem(), SolverOptions(guess_active_sets=guess))
    solution = checked(variant, solver)
    assert solution.status is PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(variant.reference().cost, rel=1e-6)
    if name != "free":
        assert guess or solver.quadratic_programs > 0


def test_every_budget_ends_with_an_honest_plan() -> None:
    variant = TASKS["all"]
    solver = Hybrid(variant.problem())
    best = solver.solve(variant.start).cost
    for iterations in range(1, 12):
        solution = solver.solve(variant.start, max_iterations=iterations)
        assert solution.iterations <= iterations
        if solution.usable:
            assert variant.violation(solution.states, solution.inputs) <= 1e-6
            assert variant.defect(solution.states, solution.inputs) <= 1e-9
            assert solution.cost >= best * (1.0 - 1e-6)
        else:
            assert solution.violation > 1e-6 and "violated by" in solution.message()
    hurried = solver.solve(variant.start, time_limit=1e-6)
    assert hurried.iterations <= 2
    assert hurried.status is not PlanStatus.CONVERGED


def test_a_solve_without_time_leaves_constraints_alone_and_says_so() -> None:
    """No time for ProxQP, to which every program would go: what comes of that violates a row, and is not called a way back."""
    variant = TASKS["speed"]
    solver = Hybrid(variant.problem(), SolverOptions(guess_active_sets=False, hessian="gauss-newton"))
    pushed = np.full((30, 2), 1.0)
    hurried = solver.solve(variant.start, pushed, max_iterations=1, time_limit=1e-9)
    assert solver.quadratic_programs == 0
    assert variant.violation(hurried.states, hurried.inputs) > 1e-6
    assert hurried.status is PlanStatus.INFEASIBLE
    patient = solver.solve(variant.start, pushed, max_iterations=1)
    assert solver.quadratic_programs > 0
    assert patient.usable


def test_aiming_anew_in_vain_leaves_the_trajectory_that_was_usable() -> None:
    variant = Variant(start=(-0.3, 0.1, 0.0), speed=0.5, force=(-0.7, 0.8))
    solver = Hybrid(variant.problem())
    too_fast = np.array([-0.3, 5.0, 0.0])
    assert not solver.run(too_fast)[0].usable
    solver.solve(variant.start)
    followed = solver.follow(np.array(variant.start), 0.0)
    before, cost = solver.trajectory(), solver.cost
    assert followed.usable
    status, _ = solver.aim_anew(too_fast, followed, 4, np.inf)
    assert status is followed
    for now, then in zip(solver.trajectory(), before, strict=True):
        np.testing.assert_array_equal(now, then)
    assert solver.worst()[0] <= 1e-6
    assert solver.cost == pytest.approx(cost, rel=1e-12)


def test_of_two_ways_back_the_cheaper_one_stays() -> None:
    variant = Variant(start=(-0.3, 0.1, 0.0), speed=0.5, force=(-0.7, 0.8))
    solver = Hybrid(variant.problem(), SolverOptions(hessian="gauss-newton", largest_multiplier=100.0))
    solver.solve(variant.start)
    too_fast = np.array([-0.3, 0.7, 0.0])
    followed = solver.follow(too_fast, 0.0, 8)
    before, cost, violation = solver.trajectory(), solver.cost, solver.worst()[0]
    assert followed is PlanStatus.RECOVERING
    status, _ = solver.aim_anew(too_fast, followed, 1, np.inf)  # one iteration from a trajectory that starts elsewhere
    assert (status, solver.cost, solver.worst()[0]) == (followed, pytest.approx(cost), pytest.approx(violation))
    for now, then in zip(solver.trajectory(), before, strict=True):
        np.testing.assert_array_equal(now, then)


def test_a_warm_start_with_multipliers_needs_fewer_iterations() -> None:
    variant = TASKS["wall"]
    solver = Hybrid(variant.problem())
    cold = solver.solve(variant.start)
    warm = solver.solve(variant.start, cold.inputs, states=cold.states, multipliers=cold.multipliers)
    assert warm.status is PlanStatus.CONVERGED
    assert warm.iterations < cold.iterations
    assert warm.cost == pytest.approx(cold.cost, rel=1e-6)


def test_the_same_bits_again() -> None:
    variant = TASKS["all"]
    one, other = (Hybrid(variant.problem()) for _ in range(2))
    first, second, third = one.solve(variant.start), one.solve(variant.start), other.solve(variant.start)
    for again in (second, third):
        np.testing.assert_array_equal(first.states, again.states)
        np.testing.assert_array_equal(first.inputs, again.inputs)
        assert (first.cost, first.iterations) == (again.cost, again.iterations)


def test_a_start_outside_is_left_and_named() -> None:
    """Beyond the wall at rest with little force: it takes some nodes to come back."""
    variant = Variant(start=(0.9, 0.0, 0.0), wall=0.8, force=(-1.5, 1.5))
    solution = Hybrid(variant.problem(), SolverOptions(largest_multiplier=1e3)).solve(variant.start)
    assert solution.status is PlanStatus.RECOVERING
    assert solution.status.flyable and not solution.usable
    assert 1 < solution.recovered_at <= solution.problem.horizon
    after = solution.states[solution.recovered_at :]
    assert after[:, 0].max() <= 0.8 + 1e-6
    assert solution.problem.constraint_names[0] in solution.message() and "node" in solution.message()
    assert (np.abs(solution.inputs[:, 0]) <= 1.5 + 1e-12).all()


def test_a_way_back_is_followed_and_not_looked_for_anew() -> None:
    """Replans from outside stay within their few iterations, and come inside."""
    variant = Variant(start=(0.9, 0.0, 0.0), wall=0.8, force=(-1.5, 1.5))
    solver = Hybrid(variant.problem(), SolverOptions(largest_multiplier=1e3, hessian="gauss-newton"))
    assert solver.solve(variant.start).status is PlanStatus.RECOVERING
    state, statuses = np.array(variant.start), []
    for _ in range(12):
        state = solver.trajectory()[0][1].copy()
        status, iterations = solver.replan(state, elapsed=0.1)
        assert status.flyable and iterations <= 1 + 2 * EXTRA_ITERATIONS
        statuses.append(status)
    assert statuses[0] is PlanStatus.RECOVERING and statuses[-1].usable


def test_a_replan_without_a_trajectory_is_a_solve() -> None:
    assert Hybrid(TASKS["free"].problem()).replan(np.zeros(3))[0] is PlanStatus.CONVERGED


def test_what_cannot_be_is_not_called_usable() -> None:
    variant = Variant(start=(0.0, 0.0, 0.0), wall=0.5, dock=0.9)
    for method in (Cddp, Hybrid):
        solution = method(variant.problem(), SolverOptions(largest_multiplier=1e3)).solve(variant.start)
        assert not solution.usable
        assert solution.violation > 0.01


def test_misuse_is_refused() -> None:
    variant = TASKS["free"]
    solver = Hybrid(variant.problem())
    with pytest.raises(DimensionError, match="state"):
        solver.solve([0.0, 0.0])
    with pytest.raises(DimensionError, match="state"):
        solver.solve([0.0, np.nan, 0.0])
    with pytest.raises(DimensionError, match="inputs"):
        solver.solve(variant.start, np.zeros((3, 2)))
    with pytest.raises(DimensionError, match="max_iterations"):
        solver.solve(variant.start, max_iterations=0)
    with pytest.raises(SolverError, match="options.penalty"):
        SolverOptions(penalty=0.0)
