"""Problems whose duration is free: analytic optima, IPOPT's, and everything else that a solver does with them."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import casadi as ca
import numpy as np
import pytest

from doorman import ocp
from doorman.exceptions import DimensionError, SolverError

GUESSES = (0.3, 0.6, 1.0, 1.7, 3.0)
"""As shares of the true duration."""
STEPS = 30


def fastest(distance: float = 1.0) -> float:
    """Duration of a drive from rest to rest with an acceleration of at most 1: half of it ahead, half of it back."""
    return 2.0 * float(np.sqrt(distance))


def drive(
    guess: float,
    weight: float = 1e-3,
    *,
    price: float = 1.0,
    upper: float = 20.0,
    speed_weight: float = 0.0,
    full: bool = False,
) -> ocp.Problem:
    """A double integrator from rest to rest at 1."""
    x, u, goal = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("goal")
    weights: Any = np.diag([0.0, speed_weight]) if full else [0.0, speed_weight]
    return ocp.SymbolicModel(x, u, ca.vertcat(x[1], u), parameters=goal).problem(
        STEPS, guess / STEPS, ocp.QuadraticCost(weights, [0.0] * 2, [weight], [1.0, 0.0], [0.0]),
        bounds=ocp.Bounds(input_lower=[-1.0], input_upper=[1.0]), parameters=[1.0],
        constraints=[ocp.Constraint("goal", x - ca.vertcat(goal, 0), equals=0, at="end")],
        free_time=ocp.FreeTime(0.1, upper, price),
    )  # fmt: skip


@pytest.mark.parametrize("share", GUESSES)
@pytest.mark.parametrize("weight", [1e-3, 0.0])
def test_the_fastest_drive_is_the_analytic_one(share: float, weight: float) -> None:
    found = ocp.Hybrid(drive(share * fastest(), weight)).solve([0.0, 0.0])
    assert found.status is ocp.PlanStatus.CONVERGED
    assert found.duration == pytest.approx(fastest(), abs=1e-5)
    assert found.duration == STEPS * found.time_step
    np.testing.assert_allclose(found.inputs[:, 0], np.repeat([1.0, -1.0], STEPS // 2), atol=1e-3)
    assert (found.states.shape, found.inputs.shape, found.gains.shape) == ((31, 2), (30, 1), (30, 1, 2))
    assert found.kkt_residual < 1e-5 and found.costates.shape == (30, 2)


def test_costs_are_integrals_over_the_time_that_is_found() -> None:
    """∫ (1 + r u²/2) dt from rest to rest has the optimum T⁴ = 18 r without bounds; full weights say the same."""
    weight = 0.5
    for full in (False, True):
        found = ocp.Hybrid(drive(4.0, weight, speed_weight=0.2, full=full)).solve([0.0, 0.0])
        rates = found.time_step * (1.0 + 0.5 * weight * found.inputs[:, 0] ** 2 + 0.1 * found.states[:-1, 1] ** 2)
        assert found.cost == pytest.approx(rates.sum(), rel=1e-9)
    smooth = ocp.Hybrid(drive(4.0, 4.0)).solve([0.0, 0.0])
    assert smooth.duration == pytest.approx((18.0 * 4.0) ** 0.25, rel=2e-3)  # a step of the input is finite


def test_bounds_and_price_decide_where_nothing_else_does() -> None:
    slow = ocp.Hybrid(drive(4.0, price=-1.0, upper=5.0)).solve([0.0, 0.0])
    assert slow.duration == pytest.approx(5.0, abs=1e-5)
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    model = ocp.SymbolicModel(x, u, ca.vertcat(x[1], u))
    cost = ocp.QuadraticCost([0.0] * 2, [1.0] * 2, [1.0], [1.0, 0.0], [0.0])
    for bounds in ((0.0, 1.0), (2.0, 1.0), (np.nan, 1.0)):
        with pytest.raises(DimensionError, match="free_time"):
            ocp.FreeTime(*bounds)
    with pytest.raises(SolverError, match="guess"):
        model.problem(10, 0.1, cost, free_time=ocp.FreeTime(1.5, 3.0))
    discrete = ocp.SymbolicModel(x, u, x, integrator="discrete")
    with pytest.raises(SolverError, match="free_time"):
        discrete.problem(10, 0.1, cost, free_time=ocp.FreeTime(0.5, 3.0))
    with pytest.raises(DimensionError, match="time_step"):
        ocp.Hybrid(drive(2.0)).solve([0.0, 0.0], time_step=-1.0)


def test_a_solver_takes_and_hands_out_what_it_does_with_a_given_time() -> None:
    solver = ocp.Hybrid(drive(4.0))
    found = solver.solve([0.0, 0.0], time_step=0.05)
    again = solver.solve([0.0, 0.0], warm_start=found)
    assert again.cost <= found.cost * (1.0 + 1e-7) and again.iterations < found.iterations
    for copied in (copy.deepcopy(solver), pickle.loads(pickle.dumps(solver))):
        assert copied.solve([0.0, 0.0], found.inputs, states=found.states).cost == pytest.approx(found.cost, rel=1e-6)
    several = solver.solve_batch([[0.0, 0.0], [0.5, 0.0]], threads=1)
    assert all(isinstance(each, ocp.Solution) for each in several)
    assert several[1].duration == pytest.approx(fastest(0.5), abs=1e-5)  # type: ignore[union-attr]
    solver.update_parameters([2.0])
    assert solver.solve([0.0, 0.0]).duration == pytest.approx(fastest(2.0), abs=1e-5)
    with pytest.raises(DimensionError, match="state"):
        solver.solve([0.0, 0.0, 1.0])


def test_replans_use_the_rest_of_the_time() -> None:
    """In closed loop, the time that is over and the time that is left stay what the whole drive takes."""
    solver, tick = ocp.Hybrid(drive(2.0)), 0.05
    solver.solve([0.0, 0.0])
    state = np.zeros(2)
    for k in range(30):
        status, _ = solver.replan(state, elapsed=tick * (k > 0))
        assert status.usable
        assert tick * k + STEPS * solver.time_step == pytest.approx(fastest(), abs=0.01)
        push = float(solver.trajectory()[1][0, 0])
        state = np.array([state[0] + tick * state[1] + 0.5 * push * tick**2, state[1] + tick * push])
    assert abs(state[0] - 1.0) < 0.2


class Parking:
    """A unicycle that parks behind an obstacle, from rest: to first order its inputs cannot move it sideways."""

    steps, duration = 40, 4.3

    def __init__(self) -> None:
        self.x, self.u = ca.SX.sym("x", 5), ca.SX.sym("u", 2)
        self.rate = ca.vertcat(
            self.x[3] * ca.cos(self.x[2]), self.x[3] * ca.sin(self.x[2]), self.x[4], self.u
        )  # fmt: skip
        self.goal, self.weights = [3.0, 1.0, 0.0, 0.0, 0.0], [1e-3, 1e-3]
        self.clear = 0.36 - ca.sumsqr(self.x[:2] - ca.DM([1.5, 0.3]))
        self.low = [-np.inf] * 3 + [-1.0, -2.0]
        self.high = [np.inf] * 3 + [1.0, 2.0]

    def problem(self, guess: float) -> ocp.Problem:
        """With the library's free time."""
        return ocp.SymbolicModel(self.x, self.u, self.rate).problem(
            self.steps, guess / self.steps, ocp.QuadraticCost([0.0] * 5, [0.0] * 5, self.weights, self.goal, [0.0] * 2),
            bounds=ocp.Bounds(self.low, self.high, [-1.0, -2.0], [1.0, 2.0]), free_time=ocp.FreeTime(0.1, 50.0),
            constraints=[
                ocp.Constraint("goal", self.x - ca.DM(self.goal), equals=0, at="end"), ocp.Constraint("obstacle", self.clear),
            ],
        )  # fmt: skip

    def step(self, x: Any, u: Any, duration: Any) -> Any:
        """x⁺ by RK4."""
        rate, h = ca.Function("rate", [self.x, self.u], [self.rate]), duration / self.steps
        a = rate(x, u)
        b = rate(x + h / 2 * a, u)
        c = rate(x + h / 2 * b, u)
        return x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c, u))

    def ipopt(self, guess: float) -> float:
        """Cost that IPOPT finds, by multiple shooting."""
        n, t = self.steps, ca.SX.sym("t")
        X, U = ca.SX.sym("X", 5, n + 1), ca.SX.sym("U", 2, n)
        clear = ca.Function("clear", [self.x], [self.clear])
        defects = [self.step(X[:, k], U[:, k], t) - X[:, k + 1] for k in range(n)]
        cost = t + sum(0.5 * t / n * ca.dot(ca.DM(self.weights) * U[:, k], U[:, k]) for k in range(n))
        nlp = {
            "x": ca.vertcat(ca.vec(X), ca.vec(U), t), "f": cost,
            "g": ca.vertcat(*defects, *[clear(X[:, k + 1]) for k in range(n)]),
        }  # fmt: skip
        solver = ca.nlpsol("ipopt", "ipopt", nlp, {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes"})
        low, high = np.tile(self.low, (n + 1, 1)), np.tile(self.high, (n + 1, 1))
        low[0] = high[0] = 0.0
        low[-1] = high[-1] = self.goal
        found = solver(
            x0=np.concatenate([np.zeros(5 * (n + 1) + 2 * n), [guess]]), ubg=0.0,
            lbx=np.concatenate([low.ravel(), np.tile([-1.0, -2.0], n), [0.1]]),
            ubx=np.concatenate([high.ravel(), np.tile([1.0, 2.0], n), [50.0]]),
            lbg=np.concatenate([np.zeros(5 * n), np.full(n, -np.inf)]),
        )  # fmt: skip
        assert solver.stats()["success"]
        return float(found["f"])


@pytest.mark.slow
def test_parking_from_any_guess_as_ipopt_does() -> None:
    """Every guess leads to a minimum; there is one for each way around the obstacle, and turns more."""
    parking = Parking()
    best, costs = parking.ipopt(parking.duration), []
    for share in GUESSES:
        guess = share * parking.duration
        found = ocp.Hybrid(parking.problem(guess)).solve([0.0] * 5)
        assert found.status is ocp.PlanStatus.CONVERGED, (share, found.message())
        costs.append(found.cost)
    assert min(costs) == pytest.approx(best, rel=1e-5)
    assert max(costs) < 1.5 * best
