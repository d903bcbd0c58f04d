"""The solvers on problems that are no doors: the local optimum of others, exact dynamics, honest statuses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from pendulum import pendulum
from point_mass import dense_solution, point_mass
from toy import Toy

from doorman.ocp import Cddp, Hybrid, PlanStatus, Solution, Solver

pytestmark = pytest.mark.slow


def solved(toy: Toy, method: type[Solver]) -> Solution:
    """A solution that holds what its status says, by the toy's own equations."""
    solution = method(toy.problem).solve(toy.start)
    assert solution.usable
    assert solution.defect <= 1e-6 and solution.violation <= 1e-6
    assert toy.violation(solution.states, solution.inputs) <= 1e-6
    np.testing.assert_allclose(toy.roll_out(solution.inputs), solution.states, atol=1e-9)
    return solution


@pytest.mark.parametrize(("make", "method"), [(pendulum, Hybrid), (point_mass, Hybrid), (point_mass, Cddp)])
def test_the_optimum_is_that_of_ipopt_or_of_one_dense_program(make: Callable[[], Toy], method: type[Solver]) -> None:
    toy = make()
    solution = solved(toy, method)
    reference = toy.reference() if make is pendulum else dense_solution(toy)
    assert solution.status is PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(reference.cost, rel=1e-6)
    np.testing.assert_allclose(solution.states, reference.states, atol=5e-3)
    assert max(float(np.max(toy.rows(x))) for x in reference.states[1:]) > -1e-6, "a row is active there"


def test_cddp_is_honest_where_it_is_stuck() -> None:
    """A row that takes several inputs to act on: CDDP stays feasible, and does not call its end an optimum unless it is one."""
    toy = pendulum()
    solution, reference = solved(toy, Cddp), toy.reference()
    if solution.status is PlanStatus.CONVERGED:
        assert solution.cost == pytest.approx(reference.cost, rel=1e-6)
    else:
        assert solution.status in (PlanStatus.STALLED, PlanStatus.ITERATION_LIMIT)
        assert solution.cost >= reference.cost * (1.0 - 1e-6)
