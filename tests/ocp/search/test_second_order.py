"""A solution of the fast iterations counts where it is a minimum; the search runs only where it is none."""

from __future__ import annotations

import casadi as ca
import pytest

from doorman import ocp
from doorman.exceptions import DoormanError
from doorman.ocp.solvers.iterations import cold_start

x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
cart = ocp.SymbolicModel(x, u, ca.vertcat(x[1], u))


def phases(solver: ocp.Hybrid, start: list[float], **guess: str) -> tuple[set[str], ocp.Solution]:
    seen: set[str] = set()
    solution = solver.solve(start, **guess, callback=lambda iterate: seen.add(iterate.phase))
    assert solution.status is ocp.PlanStatus.CONVERGED
    return seen, solution


def test_a_minimum_needs_no_search() -> None:
    """With an active bound and an active row, which the check has to leave out of the directions."""
    cost = ocp.QuadraticCost([1.0, 0.1], [10.0, 1.0], [0.1], [1.0, 0.0], [0.0])
    slow = ocp.Constraint("speed", x[1] - 0.5)
    bounds = ocp.Bounds(input_lower=[-1.0], input_upper=[1.0])
    solver = ocp.Hybrid(cart.problem(30, 0.1, cost, bounds=bounds, constraints=[slow]))
    seen, solution = phases(solver, [0.0, 0.0])
    assert seen == {"fast"}
    assert abs(solution.multipliers.rows).max() > 0.0 and abs(solution.multipliers.inputs).max() > 0.0


def test_a_saddle_is_no_minimum() -> None:
    """Halfway between two equal ends Gauss and Newton see no slope and no curvature, and stop: the search is asked."""
    cost = ocp.QuadraticCost([0.0, 0.0], [0.0, 0.1], [0.1], [1.0, 0.0], [0.0])
    ends = ocp.Residual("ends", x[0] ** 2 - 1.0, weights=10.0, at="end")
    solver = ocp.Hybrid(cart.problem(20, 0.1, cost, costs=[ends]))
    seen, _ = phases(solver, [0.0, 0.0], states="held")
    assert seen == {"fast", "interior"}


def test_a_small_cost_is_no_reason_to_aim_anew() -> None:
    """Where all that could be gained is less than an iteration's accuracy, a replan stays with its iterations."""
    cost = ocp.QuadraticCost([1e-3, 1e-4], [1e-2, 1e-3], [1e-4], [0.0, 0.0], [0.0])
    solver = ocp.Hybrid(cart.problem(30, 0.1, cost))
    solver.solve([1e-3, 0.0])
    for state in ([2e-3, 0.0], [-1e-3, 0.0], [1e-3, 1e-3]):
        status, iterations = solver.replan(state, elapsed=0.1)
        assert status.usable and iterations <= 3


def test_solvers_of_other_sizes_share_their_kernels() -> None:
    wide, force = ca.SX.sym("x", 3), ca.SX.sym("u", 2)
    other = ocp.SymbolicModel(wide, force, ca.vertcat(wide[1], force))
    ocp.Hybrid(cart.problem(5, 0.1, ocp.QuadraticCost([1.0] * 2, [1.0] * 2, [1.0], [0.0] * 2, [0.0])))
    before = len(cold_start.solve.entries)  # type: ignore[attr-defined]
    ocp.Hybrid(other.problem(5, 0.1, ocp.QuadraticCost([1.0] * 3, [1.0] * 3, [1.0] * 2, [0.0] * 3, [0.0] * 2)))
    assert len(cold_start.solve.entries) == before  # type: ignore[attr-defined]


@pytest.mark.parametrize("given", ["0.1", "soon", -0.1, 0.0, float("nan")])
def test_a_time_step_that_is_none_is_named(given: object) -> None:
    cost = ocp.QuadraticCost([1.0] * 2, [1.0] * 2, [1.0], [0.0] * 2, [0.0])
    with pytest.raises(DoormanError, match="time_step"):
        cart.problem(5, given, cost)  # type: ignore[arg-type]
