"""doorman.ocp without a door: a mass before a wall, against one dense quadratic program."""

from __future__ import annotations

import numpy as np
import pytest
from double_integrator import Rail
from proxsuite import proxqp

from doorman.ocp import Cddp, CddpOptions, PlanStatus, Problem, QuadraticCost

N, STEP = 30, 0.1
COST = QuadraticCost(
    state_weights=np.array([1.0, 0.1]),
    terminal_weights=np.array([10.0, 1.0]),
    input_weights=np.array([0.1]),
    state_goal=np.array([1.0, 0.0]),
    input_goal=np.zeros(1),
)


def problem(wall: float, speed_limit: float, slope: float = 1.0) -> Problem:
    return Problem(Rail(STEP, wall, speed_limit, slope), n_constraints=2, horizon=N, time_step=STEP, cost=COST)


def dense_solution(wall: float, speed_limit: float, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Inputs, multipliers at nodes 1 … N and cost of the same problem, condensed to a program in all inputs."""
    a, b = np.array([[1.0, STEP], [0.0, 1.0]]), np.array([[0.5 * STEP**2], [STEP]])
    free = np.vstack([np.linalg.matrix_power(a, k) @ start for k in range(1, N + 1)]).ravel()
    by_input = np.zeros((2 * N, N))
    for k in range(N):
        for j in range(k + 1):
            by_input[2 * k : 2 * k + 2, j : j + 1] = np.linalg.matrix_power(a, k - j) @ b
    weights = np.tile(COST.state_weights * STEP, N)
    weights[-2:] = COST.terminal_weights
    error = free - np.tile(COST.state_goal, N)
    hessian = by_input.T @ (weights[:, None] * by_input) + np.diag(np.tile(COST.input_weights * STEP, N))
    gradient = by_input.T @ (weights * error)
    qp = proxqp.dense.QP(N, 0, 2 * N)
    qp.settings.eps_abs, qp.settings.eps_rel = 1e-11, 0.0
    bound = np.tile([wall, speed_limit], N) - free
    qp.init(hessian, gradient, None, None, by_input, np.full(2 * N, -1e20), bound)
    qp.solve()
    assert qp.results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
    first = 0.5 * STEP * COST.state_weights @ (start - COST.state_goal) ** 2
    constant = 0.5 * weights @ error**2 + first
    return qp.results.x.copy(), qp.results.z.reshape(N, 2).copy(), float(qp.results.info.objValue + constant)


@pytest.mark.parametrize("guess", [True, False])
@pytest.mark.parametrize("accelerate", [False, True])
@pytest.mark.parametrize(
    ("wall", "speed_limit", "start", "rows"),
    [
        (9.0, 9.0, [0.0, 0.0], (0, 0)),
        (0.8, 9.0, [0.0, 0.0], (8, 0)),
        (9.0, 0.5, [0.0, 0.0], (0, 8)),
        (0.8, 0.5, [-0.3, 0.2], (2, 15)),
        (0.9, 0.6, [0.3, 0.9], (11, 2)),
        (0.7, 0.5, [0.0, 0.6], (10, 8)),
    ],
)
def test_same_optimum_as_a_dense_program(
    wall: float, speed_limit: float, start: list[float], rows: tuple[int, int], accelerate: bool, guess: bool
) -> None:
    """Also from a start that is too fast: `start` itself is not bound, every later state is."""
    state = np.array(start)
    solver = Cddp(problem(wall, speed_limit), CddpOptions(tolerance=1e-12, guess_active_sets=guess))
    solution = solver.solve(state, np.zeros((N, 1)), 200, accelerate=accelerate)
    inputs, multipliers, cost = dense_solution(wall, speed_limit, state)
    assert solution.status is PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(cost, rel=1e-8)
    np.testing.assert_allclose(solution.inputs[:, 0], inputs, atol=1e-4)
    np.testing.assert_allclose(solution.multipliers, multipliers, atol=1e-3)
    assert (multipliers[:, 0] > 1e-6).sum() >= rows[0]
    assert (multipliers[:, 1] > 1e-6).sum() >= rows[1]
    assert solution.max_violation <= 1e-9
    assert (solution.states[1:, 0] <= wall + 1e-9).all() and (solution.states[1:, 1] <= speed_limit + 1e-9).all()
    assert (solver.quadratic_programs > 0) == (not guess and max(rows) > 0)


def test_a_linear_problem_without_active_rows_takes_one_step() -> None:
    solver = Cddp(problem(9.0, 9.0))
    assert solver.solve(np.zeros(2), np.zeros((N, 1)), 1).cost == pytest.approx(
        dense_solution(9.0, 9.0, np.zeros(2))[2]
    )
    assert solver.solve(np.zeros(2), np.zeros((N, 1)), 50).iterations == 2


@pytest.mark.parametrize("start", [0.0, 0.9, 0.9999])
def test_wrong_derivatives_stall_and_never_pass_for_convergence(start: float) -> None:
    """With the sign of B wrong no step lowers the cost, however short; regularisation shrinks the prediction to nothing."""
    state = np.array([start, 0.0])
    solver = Cddp(problem(9.0, 9.0, slope=-1.0))
    solution = solver.solve(state, np.zeros((N, 1)), 50)
    assert solution.status is PlanStatus.STALLED
    assert solution.status.usable
    held = COST.total(np.tile(state, (N + 1, 1)), np.zeros((N, 1)), STEP)
    assert solution.cost == pytest.approx(held, rel=1e-9)


def test_other_parameters_without_another_solver() -> None:
    solver = Cddp(problem(0.8, 9.0))
    before = solver.solve(np.zeros(2), np.zeros((N, 1)), 100)
    solver.update_model(Rail(STEP, 0.5, 9.0, 1.0))
    after = solver.solve(np.zeros(2), np.zeros((N, 1)), 100)
    assert before.states[:, 0].max() == pytest.approx(0.8, abs=1e-8)
    assert after.states[:, 0].max() == pytest.approx(0.5, abs=1e-8)
    assert after.cost == pytest.approx(dense_solution(0.5, 9.0, np.zeros(2))[2], rel=1e-7)


def test_a_wall_that_is_passed_already_is_infeasible_unless_one_step_leads_back() -> None:
    solver = Cddp(problem(0.0, 0.5))
    back = solver.solve(np.array([0.1, 0.0]), np.zeros((N, 1)), 100)
    assert back.status.usable
    assert back.states[1, 0] == pytest.approx(0.0, abs=1e-8)
