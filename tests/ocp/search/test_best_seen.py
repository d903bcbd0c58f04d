"""What a solve returns is the best feasible trajectory that it has seen, the guess included."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest

from doorman import ocp

START = (1.0, 0.0, 0.0, 0.0)


@cache
def sharp() -> ocp.Hybrid:
    """From rest at 1 to rest at 0, where the cost 10 |x_N| has no derivative: no method of Newton's kind converges there.

    Two states stand still: with them it has the size of the cart with a pole, and its kernels.
    """
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u")
    problem = ocp.SymbolicModel(x, u, ca.vertcat(x[1], u, 0, 0)).problem(
        30, 0.1, ocp.QuadraticCost([0] * 4, [0] * 4, [1e-2], [0] * 4, [0.0]),
        bounds=ocp.Bounds(input_lower=[-1], input_upper=[1]), costs=[ocp.Cost("end", 10 * ca.norm_2(x), at="end")],
    )  # fmt: skip
    return ocp.Hybrid(problem)


@pytest.mark.parametrize("iterations", [1, 2, 5, 13, 30, 200])
def test_no_result_costs_more_than_its_guess(iterations: int) -> None:
    """No input costs exactly 10; the optimum costs less than 0.003."""
    found = sharp().solve(START, max_iterations=iterations)
    assert found.usable and found.cost <= 10.0 + 1e-6
    assert found.cost == pytest.approx(
        10.0 * np.linalg.norm(found.states[-1]) + 5e-4 * (found.inputs**2).sum(), rel=1e-9
    )
    again = sharp().solve(START, found.inputs, max_iterations=iterations)
    assert again.usable and again.cost <= found.cost * (1.0 + 1e-6)


def test_a_guess_that_is_cheaper_than_every_iterate_is_what_comes_back() -> None:
    best = sharp().solve(START)
    assert best.cost < 0.003
    hurried = sharp().solve(START, best.inputs, max_iterations=1)
    assert hurried.usable and hurried.cost <= best.cost * (1.0 + 1e-6)


def test_a_cheap_guess_outside_the_bounds_is_not_taken() -> None:
    """Twice the force that there is ends nearer; it is cut off at the bounds and costs what it then costs."""
    found = sharp().solve(START, np.full((30, 1), -2.0), max_iterations=1)
    assert np.abs(found.inputs).max() <= 1.0 + 1e-6
    assert found.violation <= 1e-6 and found.usable


def test_replans_return_to_a_guess_that_is_cheaper() -> None:
    """Full steps overshoot where the cost has an edge; what they began with is better, and comes back with feedback."""
    solver = sharp()
    best = solver.solve(START)
    cost = best.cost
    for _ in range(5):
        status, _ = solver.replan(START, elapsed=0.0)
        assert status.usable and solver.cost <= cost + 1e-6 * (1.0 + cost)
        cost = min(cost, solver.cost)
        assert np.abs(solver._work.policy.gains).max() > 0.0
