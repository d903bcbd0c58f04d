"""The search for a good minimum: as good as IPOPT's from the same guess, and honest where there is none."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from system import System
from systems import cart_pole

from doorman import ocp


@pytest.fixture(scope="module")
def cart() -> tuple[System, ocp.Hybrid]:
    system = cart_pole()
    return system, ocp.Hybrid(system.problem())


@pytest.mark.slow
@pytest.mark.parametrize("guess", [None, "held"])
def test_a_pole_swings_up_as_cheaply_as_ipopt_has_it(cart: tuple[System, ocp.Hybrid], guess: str | None) -> None:
    """Gauss and Newton's Hessian alone ends at more than twice the cost from half of these starts."""
    system, solver = cart
    for start in system.starts(8, seed=3):
        solution = solver.solve(start, states=guess)
        reference = system.ipopt(start, system.held(start), np.zeros((system.horizon, 1)))
        assert solution.status is ocp.PlanStatus.CONVERGED and solution.defect < 1e-9
        assert solution.cost <= reference.cost * (1.0 + 1e-6)
        assert solution.kkt_residual < 1e-2  # the cost is in the thousands


@pytest.mark.slow
def test_a_guess_in_a_word_is_the_array_that_it_names(cart: tuple[System, ocp.Hybrid]) -> None:
    system, solver = cart
    start = next(system.starts(1))
    part = np.linspace(0.0, 1.0, system.horizon + 1)[:, None]
    for word, states in (("held", system.held(start)), ("straight", (1.0 - part) * start)):
        named, given = solver.solve(start, states=word), solver.solve(start, np.zeros((50, 1)), states=states)
        assert named.cost == pytest.approx(given.cost, rel=1e-9) and named.iterations == given.iterations


@pytest.mark.slow
@pytest.mark.parametrize("late", [1.0, 3.0])
def test_replans_swing_a_pole_up_though_the_time_is_wrong(cart: tuple[System, ocp.Hybrid], late: float) -> None:
    """Where the trajectory is shifted too far, an unstable system drives it away: it has to be found anew."""
    system, solver = cart
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u")
    advance, random = ca.Function("advance", [x, u], [system.step(x, u)]), np.random.default_rng(2)
    for start in system.starts(2, seed=7):
        state, usable = np.asarray(start), 0
        solver.solve(state)
        for k in range(120):
            status, _ = solver.replan(state, elapsed=late * system.time_step * (k > 0))
            states, inputs = solver.trajectory()
            usable += status.usable
            if status.usable:
                steps = [np.array(advance(states[i], inputs[i])).ravel() for i in (0, 20, 49)]
                assert np.abs(np.array(steps) - states[[1, 21, 50]]).max() < 1e-6
                assert np.abs(inputs).max() <= 80.0 + 1e-6
            state = np.array(advance(state, inputs[0])).ravel() + 1e-3 * random.normal(size=4)
        assert usable >= 118 and abs(state[1]) < 0.2 and abs(state[0]) < 0.2


@pytest.mark.slow
def test_what_has_no_solution_is_said_to_have_none() -> None:
    """A place too far for the motor; and the same solver goes on with one that is near enough."""
    x, u, place = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("place")
    model = ocp.SymbolicModel(x, u, ca.vertcat(x[1], u), parameters=place)
    cost = ocp.QuadraticCost([0.0, 0.0], [0.0, 0.0], [1.0], [0.0, 0.0], [0.0])
    problem = model.problem(
        20, 0.1, cost, bounds=ocp.Bounds(input_lower=[-1.0], input_upper=[1.0]), parameters=[50.0],
        constraints=[ocp.Constraint("place", x[0], equals=place, unit="m", at="end")],
    )  # fmt: skip
    solver = ocp.Hybrid(problem)
    far = solver.solve([0.0, 0.0])
    assert far.status is ocp.PlanStatus.INFEASIBLE and "place [m]" in far.message() and far.violation > 40.0
    assert np.abs(far.inputs).max() <= 1.0 + 1e-9
    solver.update_parameters([0.8])
    assert solver.solve([0.0, 0.0]).status is ocp.PlanStatus.CONVERGED
