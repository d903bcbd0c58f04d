"""Models of plain Python functions: the same optima as with kernels, and a user's mistakes come out as the user's."""

from __future__ import annotations

import functools
import gc
import traceback
from typing import Any

import casadi as ca
import numpy as np
import pytest

from doorman.exceptions import DimensionError, SolverError
from doorman.ocp import (
    Bounds,
    Cddp,
    Constraint,
    Hybrid,
    PlanStatus,
    Problem,
    PythonModel,
    QuadraticCost,
    Solution,
    Solver,
    SymbolicModel,
    runge_kutta,
)  # fmt: skip

METHODS = [Hybrid, Cddp]
DT, SPEED, FORCE = 0.1, 0.5, 1.0
COST = QuadraticCost(
    state_weights=[1.0, 0.1], terminal_weights=[10.0, 1.0], input_weights=[0.1], state_goal=[1.0, 0.0], input_goal=[0.0]
)
"""The tutorial's."""
FREE = QuadraticCost(
    state_weights=[0.0, 0.0], terminal_weights=[0.0, 0.0], input_weights=COST.input_weights,
    state_goal=COST.state_goal, input_goal=COST.input_goal,
)  # fmt: skip
PUSHED = Bounds(input_lower=[-FORCE], input_upper=[FORCE])

pytestmark = pytest.mark.slow


def roll(x: Any, u: Any) -> Any:
    return [x[0] + DT * x[1] + 0.5 * DT**2 * u[0], x[1] + DT * u[0]]


def too_fast(x: Any) -> Any:
    return x[1] - SPEED


def cart(step: Any = roll, constraints: Any = too_fast, derivatives: Any = "differences") -> Problem:
    """The sizes of the tutorial's cart, so that its kernels serve."""
    return PythonModel(step, constraints, derivatives=derivatives).problem(COST, 40, DT, PUSHED)


# ---------------------------------------------------------------- optima


@functools.cache
def reference() -> Solution:
    """Of the same cart in symbols."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    model = SymbolicModel(x, u, ca.vertcat(x[1], u))
    slow = [Constraint("speed", x[1] - SPEED)]
    return Hybrid(model.problem(40, DT, COST, bounds=PUSHED, constraints=slow)).solve([0.0, 0.0])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("derivatives", ["differences", "complex step"])
def test_either_derivatives_lead_to_the_optimum(derivatives: str, method: type[Solver]) -> None:
    solution = method(cart(derivatives=derivatives)).solve([0.0, 0.0])
    assert solution.status is PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(reference().cost, rel=1e-6)


def cart_of_every_kind(derivatives: Any) -> Problem:
    """The cart again: its cost in functions, its limit on the next speed as a mixed row, and where it has to be at the end."""
    model = PythonModel(
        roll,
        input_constraints=lambda x, u: x[1] + DT * u[0] - SPEED,
        end_constraints=lambda x: [0.5 - x[0]],
        stage_cost=lambda x, u: 0.5 * DT * COST.state_weights @ (x - COST.state_goal) ** 2,
        end_cost=lambda x: 0.5 * COST.terminal_weights @ (x - COST.state_goal) ** 2,
        derivatives=derivatives,
    )
    return model.problem(FREE, 40, DT, PUSHED, ["speed", "arrival"])


def test_functions_of_every_kind() -> None:
    problem = cart_of_every_kind("complex step")
    assert (problem.n_constraints, problem.n_input_constraints, problem.n_end_constraints) == (0, 1, 1)
    solution = Hybrid(problem).solve([0.0, 0.0])
    assert solution.status is PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(reference().cost, rel=1e-6)
    np.testing.assert_allclose(solution.states, reference().states, atol=2e-3)
    assert solution.kkt_residual < 1e-3
    assert (solution.states[1:, 1] <= SPEED + 1e-6).all() and (solution.states[:, 1] > SPEED - 1e-4).any()


def test_functions_may_keep_and_change_what_they_get() -> None:
    kept: list[Any] = []

    def greedy(x: Any, u: Any) -> Any:
        ahead = np.array(roll(x, u))
        kept.append(x)
        x[:], u[:] = -1.0, -1.0
        return ahead

    greedy_one, plain = Hybrid(cart(greedy)).solve([0.0, 0.0]), Hybrid(cart()).solve([0.0, 0.0])
    np.testing.assert_array_equal(greedy_one.states, plain.states)
    assert all((x == -1.0).all() for x in kept)


def test_the_callback_lives_as_long_as_the_solver() -> None:
    solver = Hybrid(cart())
    gc.collect()
    assert solver.solve([0.0, 0.0]).usable


# ---------------------------------------------------------------- mistakes


class OutOfTrackError(Exception):
    """A user's own."""


def deep_inside(x: Any) -> None:
    if x[0] > 0.2:
        raise OutOfTrackError("no track beyond 0.2 m")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("where", ["step", "constraints"])
def test_what_a_function_raises_comes_out_with_its_traceback(method: type[Solver], where: str) -> None:
    open_track = [False]

    def step(x: Any, u: Any) -> Any:
        if where == "step" and not open_track[0] and u[0] != 0.0:
            deep_inside(x)
        return roll(x, u)

    def limit(x: Any) -> Any:
        if where == "constraints" and not open_track[0] and x[1] != 0.0:
            deep_inside(x)
        return too_fast(x)

    solver = method(cart(step, limit))
    with pytest.raises(OutOfTrackError, match="beyond 0.2 m") as caught:
        solver.solve([0.0, 0.0])
    names = [frame.name for frame in traceback.extract_tb(caught.value.__traceback__)]
    assert names[-1] == "deep_inside" and names[-2] == ("step" if where == "step" else "limit")
    open_track[0] = True
    assert solver.solve([0.0, 0.0]).status is PlanStatus.CONVERGED


def test_an_interrupt_gets_through() -> None:
    def step(x: Any, u: Any) -> Any:
        if 0.2 < x[0] < 0.9:
            raise KeyboardInterrupt
        return roll(x, u)

    solver = Hybrid(cart(step))
    with pytest.raises(KeyboardInterrupt):
        solver.solve([0.0, 0.0])


@pytest.mark.parametrize(("wrong", "match"), [
    (lambda x: x, "step: wrong shape .*given \\(1,\\).*shape \\(2,\\)"),
    (lambda x: [x[0], [1.0]], "step: not an array of numbers"),
    (lambda x: "far", "step: not an array of numbers"),
    (lambda x: None, "step: not an array of numbers"),
    (lambda x: [1j, 0.0], "step: not real"),
])  # fmt: skip
def test_a_wrong_return_is_named(wrong: Any, match: str) -> None:
    """At once where it shows at the goal, else from the solve."""

    def late(x: Any, u: Any) -> Any:
        return wrong(np.array([9.0])) if 0.2 < x[0] < 0.9 else roll(x, u)

    solver = Hybrid(cart(late))
    with pytest.raises(DimensionError, match=match):
        solver.solve([0.0, 0.0])


def test_a_wrong_return_at_the_goal_is_refused_at_once() -> None:
    with pytest.raises(DimensionError, match=r"step: wrong shape .*\(3,\)"):
        cart(lambda x, u: [*x, u[0]])
    with pytest.raises(DimensionError, match="constraints: wrong shape"):
        cart(constraints=lambda x: np.zeros((2, 2)))
    with pytest.raises(DimensionError, match="constraints: not an array of numbers"):
        cart(constraints=lambda x: None)
    with pytest.raises(ZeroDivisionError):
        cart(lambda x, u: [1.0 / 0.0, 0.0])
    with pytest.raises(SolverError, match="derivatives"):
        cart(derivatives="guesses")
    with pytest.raises(DimensionError, match="constraint_names"):
        PythonModel(roll, too_fast).problem(COST, 40, DT, PUSHED, ["one", "too many"])


def test_complex_steps_are_refused_where_they_are_wrong() -> None:
    """With differences the same function will do."""
    for limit in (lambda x: abs(x[1] + 0.1) - SPEED, lambda x: np.real(x[1] - SPEED)):
        with pytest.raises(SolverError, match="constraints: complex steps and differences"):
            cart(constraints=limit, derivatives="complex step")
        assert cart(constraints=limit).n_constraints == 1


@pytest.mark.parametrize("name", ["step", "constraints"])
def test_nan_is_an_error_that_names_the_function(name: str) -> None:
    def step(x: Any, u: Any) -> Any:
        return [np.nan, 0.0] if name == "step" and 0.2 < x[0] < 0.9 else roll(x, u)

    def limit(x: Any) -> Any:
        return np.nan if name == "constraints" and 0.2 < x[0] < 0.9 else too_fast(x)

    with pytest.raises(SolverError, match=f"{name}: returned NaN"):
        Hybrid(cart(step, limit)).solve([0.0, 0.0])


def test_a_start_without_a_value_is_no_error_where_infinite() -> None:
    solution = Hybrid(cart(constraints=lambda x: np.inf if x[0] < -5.0 else too_fast(x))).solve([-6.0, 0.0])
    assert solution.status is PlanStatus.INVALID_STATE


# ---------------------------------------------------------------- helpers


def swing(x: Any, u: Any) -> Any:
    return [x[1], -np.sin(x[0]) + u[0]]


def test_runge_kutta_is_of_fourth_order() -> None:
    start, push = np.array([1.0, 0.3]), np.array([0.2])
    exact = runge_kutta(swing, 0.8, substeps=256)(start, push)
    errors = [np.abs(runge_kutta(swing, 0.8, substeps=n)(start, push) - exact).max() for n in (2, 4, 8)]
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.3)
    np.testing.assert_allclose(runge_kutta(lambda x, u: [x[1], u[0]], DT)([1.0, 2.0], [3.0]), [1.215, 2.3], rtol=1e-14)


def test_runge_kutta_refuses_no_step() -> None:
    with pytest.raises(DimensionError, match="time_step"):
        runge_kutta(swing, 0.0)
    with pytest.raises(DimensionError, match="substeps"):
        runge_kutta(swing, 0.1, substeps=0)
