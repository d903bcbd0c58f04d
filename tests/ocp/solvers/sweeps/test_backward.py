"""CDDP's backward pass against a quadratic program and a KKT system at every node, solved by others."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from proxsuite import proxqp
from random_horizon import N, cart, door, move_inside, random_horizon

from doorman.numba_types.handles import Handle, held
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.backward import DONE, NOT_CONVEX, backward
from doorman.ocp.solvers.sweeps.stage_qp import StageQpSolver
from doorman.ocp.solvers.sweeps.sweep import terminal_value

Array = NDArray[np.float64]


@pytest.fixture(params=[cart, door])
def problem(request: pytest.FixtureRequest) -> Problem:
    return request.param()


def feasible_horizon(problem: Problem, rng: np.random.Generator, guess: bool = True) -> Workspace:
    work = random_horizon(problem, rng, defects=False)
    work = work._replace(settings=work.settings._replace(guess_active_sets=int(guess)))
    move_inside(work, problem, rng)
    work.policy.gains[:] = np.nan
    return work


def run(problem: Problem, work: Workspace, regularization: float = 0.0) -> tuple[int, int]:
    """A whole backward pass: its code, and the number of programs that were left to ProxQP."""
    model, memory, qp = Handle(problem.model), held(work), StageQpSolver(problem.nu, len(work.program.constraints))
    terminal_value(model, memory)
    work.result.change = 0.0
    code, asked = backward(model, memory, N - 1, regularization, False), 0
    while code >= 0:
        asked += 1
        assert qp.solve(work.program)
        work.program.active[code] = work.program.multipliers > 1e-8
        code = backward(model, memory, code, regularization, True)
    return int(code), asked


def rows_of_node(work: Workspace, k: int) -> tuple[Array, Array, list[tuple[str, tuple[int, ...], int]]]:
    """[C_x | C_u] and c of everything that the input of node k is responsible for, and where its multipliers belong."""
    nominal, linear, program = work.nominal, work.linear, work.program
    nx, nu = nominal.states.shape[1], nominal.inputs.shape[1]
    jacobian = linear.jacobians[k]
    ahead = np.hstack([jacobian[:, :nx], jacobian[:, nx + 1 : nx + 1 + nu]])
    slopes, values, places = [], [], []
    for i in range(nominal.rows.shape[1]):
        slopes.append(linear.row_jacobians[k, i, :nx] @ ahead)
        values.append(nominal.rows[k, i])
        places.append(("rows", (k, i), 1))
    for i in range(len(nominal.end_rows) if k == N - 1 else 0):
        slopes.append(linear.end_row_jacobians[i, :nx] @ ahead)
        values.append(nominal.end_rows[i])
        places.append(("end_rows", (i,), 1))
    for i in range(nominal.input_rows.shape[1]):
        row = linear.input_row_jacobians[k, i]
        slopes.append(np.concatenate([row[:nx], row[nx + 1 : nx + 1 + nu]]))
        values.append(nominal.input_rows[k, i])
        places.append(("input_rows", (k, i), 1))
    for index, side, limit in zip(program.bounded, program.side.astype(int), program.limit, strict=True):
        of_state = index < nx
        slopes.append(side * (ahead[index] if of_state else np.eye(nx + nu)[index]))
        number = nominal.states[k + 1, index] if of_state else nominal.inputs[k, index - nx]
        values.append(side * (number - limit))
        places.append(("states", (k, index), side) if of_state else ("inputs", (k, index - nx), side))
    return np.array(slopes).reshape(-1, nx + nu), np.array(values), places


def solve_program(hessian: Array, gradient: Array, rows: Array, values: Array) -> tuple[Array, Array]:
    """V and λ of min ½ vᵀHv + gᵀv subject to c + D v ≤ 0."""
    qp = proxqp.dense.QP(len(gradient), 0, len(values))
    qp.settings.eps_abs, qp.settings.eps_rel = 1e-11, 0.0
    qp.init(hessian, gradient, None, None, rows, np.full(len(values), -1e20), -values)
    qp.solve()
    assert qp.results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
    return qp.results.x.copy(), qp.results.z.copy()


@pytest.mark.parametrize("regularization", [0.0, 2.0])
@pytest.mark.parametrize("guess", [True, False])
def test_every_node_is_solved_as_by_proxqp_and_its_active_rows_are_kept(
    problem: Problem, guess: bool, regularization: float, rng: np.random.Generator
) -> None:
    nx, constrained = problem.nx, 0
    for _ in range(3):
        work = feasible_horizon(problem, rng, guess)
        code, asked = run(problem, work, regularization)
        assert code == DONE
        assert guess or asked >= 2
        weights, error = work.weights.terminal, work.nominal.states[N] - work.weights.state_goal
        value, slope, decrease = np.diag(weights), weights * error, 0.0
        expected = {name: np.zeros_like(array) for name, array in work.multipliers._asdict().items()}
        for k in range(N - 1, -1, -1):
            hessian, gradient = node_model(work, k, value, slope, regularization)
            rows, values, places = rows_of_node(work, k)
            offset, multipliers = solve_program(hessian[nx:, nx:], gradient[nx:], rows[:, nx:], values)
            active = multipliers > 1e-7
            constrained += bool(active.any())
            feedback = keep(hessian, rows[active], nx)
            np.testing.assert_allclose(work.policy.gains[k, :, nx], offset, rtol=1e-5, atol=1e-7)
            np.testing.assert_allclose(work.policy.gains[k, :, :nx], feedback, rtol=1e-5, atol=1e-6)
            for (name, index, side), multiplier in zip(places, multipliers * active, strict=True):
                expected[name][index] += side * multiplier
            policy = np.vstack([np.eye(nx), feedback])
            slope = policy.T @ (gradient + hessian @ np.append(np.zeros(nx), offset))
            value = policy.T @ hessian @ policy
            decrease -= gradient[nx:] @ offset + 0.5 * offset @ hessian[nx:, nx:] @ offset
        for name, array in expected.items():
            scale = 1.0 + np.abs(array).max(initial=0.0)
            np.testing.assert_allclose(getattr(work.multipliers, name), array, atol=1e-5 * scale, err_msg=name)
        assert work.result.decrease == pytest.approx(decrease, rel=1e-5, abs=1e-8)
        change = np.abs(work.weights.input * work.policy.gains[:, :, nx]).max()
        assert work.result.change == pytest.approx(change, rel=1e-12)
    assert constrained >= 6


def node_model(work: Workspace, k: int, value: Array, slope: Array, regularization: float) -> tuple[Array, Array]:
    """Hessian and gradient in [δx, δu] of the stage cost plus the value of the next state."""
    weights, jacobian, nx = work.weights, work.linear.jacobians[k], len(value)
    nu = len(weights.input)
    ahead = np.hstack([jacobian[:, :nx], jacobian[:, nx + 1 : nx + 1 + nu]])
    diagonal = np.concatenate([weights.state, weights.input])
    errors = np.concatenate(
        [work.nominal.states[k] - weights.state_goal, work.nominal.inputs[k] - weights.input_goal]
    )  # fmt: skip
    hessian = np.diag(diagonal) + ahead.T @ value @ ahead
    hessian[nx:, nx:] += regularization * np.diag(weights.input)
    return hessian, diagonal * errors + ahead.T @ slope


def keep(hessian: Array, rows: Array, nx: int) -> Array:
    """K of δu = K δx that is optimal with the rows kept active."""
    nu, m = len(hessian) - nx, len(rows)
    kkt = np.block([[hessian[nx:, nx:], rows[:, nx:].T], [rows[:, nx:], np.zeros((m, m))]])
    return -np.linalg.solve(kkt, np.vstack([hessian[nx:, :nx], rows[:, :nx]]))[:nu]


def test_the_program_that_is_handed_out_is_the_nodes_own(problem: Problem, rng: np.random.Generator) -> None:
    work, nx = feasible_horizon(problem, rng, False), problem.nx
    model, memory = Handle(problem.model), held(work)
    terminal_value(model, memory)
    node = backward(model, memory, N - 1, 0.0, False)
    assert node == N - 1
    weights = work.weights.terminal
    slope = weights * (work.nominal.states[N] - work.weights.state_goal)
    hessian, gradient = node_model(work, node, np.diag(weights), slope, 0.0)
    rows, values, _ = rows_of_node(work, node)
    np.testing.assert_allclose(work.program.hessian, hessian[nx:, nx:], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(work.program.gradient, gradient[nx:], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(work.program.jacobian, rows[:, nx:], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(work.program.constraints, values, rtol=1e-12, atol=1e-14)


def test_rows_of_the_end_bind_its_own_node_alone(rng: np.random.Generator) -> None:
    problem = cart()
    work = feasible_horizon(problem, rng)
    work.nominal.end_rows[:] = 0.0
    assert run(problem, work)[0] == DONE
    row = 2  # after the two rows of the states
    assert not work.program.active[: N - 1, row].any()


def test_a_pass_that_is_not_convex_is_refused(problem: Problem, rng: np.random.Generator) -> None:
    work = feasible_horizon(problem, rng)
    work.linear.jacobians[:, :, problem.nx + 1 :] *= 0.1
    assert run(problem, work, regularization=-1e4)[0] == NOT_CONVEX
    assert run(problem, work)[0] == DONE
    work.linear.jacobians[2, 0, 0] = np.nan
    assert run(problem, work)[0] == NOT_CONVEX
