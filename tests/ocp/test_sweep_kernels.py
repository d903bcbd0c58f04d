"""Kernels of the sweeps against dense textbook twins, finite differences, and their own plain Python."""

from __future__ import annotations

import numpy as np
import pytest
from door_tasks import model_of, planner_of, start_state
from finite_differences import central_difference

from doorman.ocp import augmented_lagrangian, backward, forward, functions, riccati
from doorman.ocp.door_problem import door_problem
from doorman.ocp.problem import Problem
from doorman.ocp.workspace import VECTOR_WIDTH, Workspace

NX, NU, NH = 9, 8, 6


@pytest.fixture(scope="module")
def problem() -> Problem:
    return door_problem(model_of("paper"))


def workspace_at(problem: Problem, states: np.ndarray, inputs: np.ndarray) -> Workspace:
    work = Workspace.of(problem)
    work.nominal.states[:] = states
    work.nominal.inputs[:] = inputs
    return work


@pytest.fixture
def work(problem: Problem, rng: np.random.Generator) -> Workspace:
    """A trajectory that rides along constraints, off the optimum."""
    model, state = model_of("paper"), start_state("paper", "active")
    inputs = planner_of("paper").plan(state).inputs + 0.03 * rng.normal(size=(50, NU))
    states = [state]
    for u in inputs:
        states.append(model.step(states[-1], u))
    return workspace_at(problem, np.array(states), inputs)


def random_node(problem: Problem, k: int, rng: np.random.Generator) -> Workspace:
    """Random linearisation, value function and point of one node."""
    work = workspace_at(problem, rng.normal(size=(51, NX)), rng.normal(size=(50, NU)))
    work.policy.jacobians[k, :, : NX + NU + 1] = rng.normal(size=(NX, NX + NU + 1))
    root = rng.normal(size=(NX, NX + 2))
    work.scratch.value[:, :NX] = root @ root.T
    work.scratch.value[:, NX + NU] = rng.normal(size=NX)
    return work


def dense_node(
    work: Workspace, problem: Problem, k: int, regularization: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Hessian and gradient in [δx, δu] of the stage cost plus the value after the linearised step; A and B."""
    cost, dt = problem.cost, problem.time_step
    jacobian, value = work.policy.jacobians[k], work.scratch.value
    by_both, defect = jacobian[:, : NX + NU], jacobian[:, NX + NU]
    weights = np.concatenate([cost.state_weights * dt, cost.input_weights * dt])
    errors = np.concatenate([work.nominal.states[k] - cost.state_goal, work.nominal.inputs[k] - cost.input_goal])
    hessian = np.diag(weights) + by_both.T @ value[:, :NX] @ by_both
    hessian[NX:, NX:] += regularization * np.diag(cost.input_weights * dt)
    gradient = weights * errors + by_both.T @ (value[:, :NX] @ defect + value[:, NX + NU])
    return hessian, gradient, by_both[:, :NX], by_both[:, NX:]


def test_rows_are_padded_to_the_vector_width(problem: Problem) -> None:
    work = Workspace.of(problem)
    assert len(work.sizes.width) == 24 >= NX + NU + 1
    assert len(work.sizes.width) % VECTOR_WIDTH == 0
    swapped = work.swapped()
    assert swapped.nominal is work.trial and swapped.trial is work.nominal


@pytest.mark.parametrize("regularization", [0.0, 10.0])
def test_one_node_equals_the_textbook_riccati_step(
    problem: Problem, regularization: float, rng: np.random.Generator
) -> None:
    for k in (0, 17, 49):
        work = random_node(problem, k, rng)
        hessian, gradient, _, _ = dense_node(work, problem, k, regularization)
        riccati.expand(work, k, regularization)
        np.testing.assert_allclose(work.scratch.hessian[:, : NX + NU], hessian, rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(work.scratch.hessian[:, NX + NU], gradient, rtol=1e-11, atol=1e-11)
        assert riccati.eliminate(work, k)
        riccati.substitute(work, k, work.scratch.half)
        by_input, mixed = hessian[NX:, NX:], hessian[NX:, :NX]
        feedback, offset = -np.linalg.solve(by_input, mixed), -np.linalg.solve(by_input, gradient[NX:])
        tolerance = {"rtol": 1e-8, "atol": 1e-8}
        np.testing.assert_allclose(work.policy.factors[k], np.linalg.cholesky(by_input), **tolerance)
        np.testing.assert_allclose(work.policy.gains[k, :, :NX], feedback, **tolerance)
        np.testing.assert_allclose(work.policy.gains[k, :, NX + NU], offset, **tolerance)
        before = hessian[:NX, :NX] + mixed.T @ feedback
        np.testing.assert_allclose(work.scratch.value[:, :NX], before, **tolerance)
        np.testing.assert_allclose(work.scratch.value[:, NX + NU], gradient[:NX] + mixed.T @ offset, **tolerance)
        np.testing.assert_array_equal(work.scratch.value[:, :NX], work.scratch.value[:, :NX].T)


def test_a_node_that_is_not_convex_is_refused(problem: Problem, rng: np.random.Generator) -> None:
    work = random_node(problem, 5, rng)
    work.scratch.value[:, :NX] *= -1.0
    riccati.expand(work, 5, 0.0)
    assert not riccati.eliminate(work, 5)
    work.scratch.hessian[NX, NX] = np.nan
    assert not riccati.eliminate(work, 5)


def test_last_value_is_the_terminal_cost(problem: Problem, work: Workspace) -> None:
    riccati.terminal_value(work)
    cost = problem.cost
    np.testing.assert_array_equal(work.scratch.value[:, :NX], np.diag(cost.terminal_weights))
    gradient = cost.terminal_weights * (work.nominal.states[50] - cost.state_goal)
    np.testing.assert_allclose(work.scratch.value[:, NX + NU], gradient, rtol=1e-14)


def test_backward_pass_equals_a_dense_kkt_solve_at_every_node(problem: Problem, work: Workspace) -> None:
    """The active rows are kept: [δu, λ](δx) from one KKT system; V from the quadratic model along that policy."""
    backward.linearize(problem.model, work)
    riccati.terminal_value(work)
    constrained = 0
    for k in range(49, -1, -1):
        hessian, gradient, a, b = dense_node(work, problem, k, 0.0)
        with_earlier = work.scratch.result[2]
        assert backward.backward(one_node(work, k), 0, 0.0, True, False) == backward.DONE
        c, h = work.policy.constraint_jacobians[k], work.nominal.constraints[k]
        rows = np.flatnonzero(work.policy.active[k])
        constrained += len(rows) > 0
        m = len(rows)
        kkt = np.block([[hessian[NX:, NX:], (c[rows] @ b).T], [c[rows] @ b, np.zeros((m, m))]])
        right = np.hstack([np.vstack([hessian[NX:, :NX], c[rows] @ a]), np.append(gradient[NX:], h[rows])[:, None]])
        solution = -np.linalg.solve(kkt, right)
        feedback, offset, multipliers = solution[:NU, :NX], solution[:NU, NX], solution[NU:, NX]
        np.testing.assert_allclose(work.policy.gains[k, :, :NX], feedback, rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(work.policy.gains[k, :, NX + NU], offset, rtol=1e-6, atol=1e-10)
        np.testing.assert_allclose(work.policy.multipliers[k, rows], multipliers, rtol=1e-6, atol=1e-9)
        assert not np.delete(work.policy.multipliers[k], rows).any()
        assert (multipliers >= -1e-12).all()
        assert (h + c @ b @ offset).max() <= 1e-9
        policy = np.vstack([np.eye(NX), feedback])
        np.testing.assert_allclose(work.scratch.value[:, :NX], policy.T @ hessian @ policy, rtol=1e-8, atol=1e-9)
        along = policy.T @ (gradient + hessian @ np.append(np.zeros(NX), offset))
        np.testing.assert_allclose(work.scratch.value[:, NX + NU], along, rtol=1e-8, atol=1e-9)
        drop = -gradient[NX:] @ offset - 0.5 * offset @ hessian[NX:, NX:] @ offset
        assert work.scratch.result[2] - with_earlier == pytest.approx(drop, rel=1e-6, abs=1e-12)
    assert constrained >= 5


def one_node(work: Workspace, k: int) -> Workspace:
    """The same memory, seen as a horizon of node k alone."""
    node = slice(k, k + 1)
    return work._replace(
        nominal=work.nominal._replace(
            states=work.nominal.states[k : k + 2],
            inputs=work.nominal.inputs[node],
            constraints=work.nominal.constraints[node],
        ),
        policy=type(work.policy)(*[field[node] for field in work.policy]),
    )


def test_proxqp_is_asked_where_a_row_is_violated(problem: Problem, work: Workspace) -> None:
    """Without guesses the kernel hands out the very quadratic program of the dense model."""
    backward.linearize(problem.model, work)
    riccati.terminal_value(work)
    node = backward.backward(work, 49, 0.0, False, False)
    assert 0 <= node < 49
    assert not work.policy.active[node + 1 :].any()
    free = Workspace.of(problem)
    for mine, theirs in zip(
        (*free.nominal, *free.policy, *free.scratch), (*work.nominal, *work.policy, *work.scratch), strict=True
    ):
        mine[...] = theirs
    riccati.terminal_value(free)
    free.nominal.constraints[node] = -1.0  # so that the sweep goes on beyond the node that was asked for
    assert backward.backward(free, 49, 0.0, False, False) < node
    riccati.terminal_value(free)
    for k in range(49, node, -1):
        riccati.expand(free, k, 0.0)
        assert riccati.eliminate(free, k)
    hessian, gradient, _, b = dense_node(free, problem, node, 0.0)
    np.testing.assert_allclose(work.qp.hessian, hessian[NX:, NX:], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(work.qp.gradient, gradient[NX:], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(work.qp.jacobian, work.policy.constraint_jacobians[node] @ b, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(work.qp.constraints, work.nominal.constraints[node])


@pytest.mark.parametrize("name", ["paper", "heavy", "closer", "seven joints"])
def test_linearisation_against_finite_differences(name: str, rng: np.random.Generator) -> None:
    """What the solvers call through `functions`, in kernels and in plain Python."""
    model, problem = model_of(name), door_problem(model_of(name), disturbance=-0.4)
    nx, nu, nh = problem.nx, problem.nu, problem.n_constraints
    x = start_state(name, "moving") + 0.05 * rng.normal(size=nx)
    u = model.hover_input + rng.normal(size=nu)

    def step(z: np.ndarray) -> np.ndarray:
        out = np.empty(nx)
        functions.step(problem.model, z[:nx].copy(), z[nx:].copy(), out)
        return out

    def constrain(z: np.ndarray) -> np.ndarray:
        h = np.empty(nh)
        functions.constrain(problem.model, z.copy(), h)
        return h

    work = Workspace.of(problem)
    work.nominal.states[0], work.nominal.states[1] = x, step(np.concatenate([x, u]))
    work.nominal.inputs[0] = u
    one = one_node(work, 0)
    backward.linearize(problem.model, one)
    numeric = central_difference(step, np.concatenate([x, u]))
    np.testing.assert_allclose(one.policy.jacobians[0, :, : nx + nu], numeric, atol=5e-8)
    assert not one.policy.jacobians[0, :, nx + nu :].any()
    after = work.nominal.states[1]
    np.testing.assert_allclose(one.nominal.constraints[0], constrain(after), atol=1e-15)
    margin = model.scenario.planner.margin
    np.testing.assert_allclose(constrain(after), model.constraints(after) + margin, atol=1e-15)
    numeric = central_difference(constrain, after.copy())
    np.testing.assert_allclose(one.policy.constraint_jacobians[0], numeric, atol=5e-8)


def test_shooting_linearisation_has_the_defects(problem: Problem, work: Workspace, rng: np.random.Generator) -> None:
    work.nominal.states[1:] += 0.01 * rng.normal(size=(50, NX))
    largest = augmented_lagrangian.linearize_shooting(problem.model, work)
    model, defects = model_of("paper"), []
    for x, u, after in zip(work.nominal.states, work.nominal.inputs, work.nominal.states[1:], strict=False):
        defects.append(model.step(x, u) - after)
    np.testing.assert_allclose(work.policy.jacobians[:, :, NX + NU], defects, atol=1e-14)
    assert largest == pytest.approx(np.abs(defects).max(), rel=1e-12)


def test_one_penalised_sweep_is_the_newton_step_of_the_whole_trajectory(
    problem: Problem, work: Workspace, rng: np.random.Generator
) -> None:
    """Against one dense least-squares-like system in all states and inputs, with defects and penalties."""
    n, penalty = 50, 3e3
    work.nominal.states[1:] += 1e-3 * rng.normal(size=(n, NX))
    augmented_lagrangian.linearize_shooting(problem.model, work)
    work.policy.multipliers[:] = rng.uniform(0.0, 2.0, (n, NH))
    work.policy.active[:] = rng.random((n, NH)) < 0.2
    active, multipliers = work.policy.active.copy(), work.policy.multipliers.copy()
    assert augmented_lagrangian.sweep(work, penalty)
    augmented_lagrangian.step_along(work, penalty)
    cost, dt = problem.cost, problem.time_step
    states, inputs = work.nominal.states, work.nominal.inputs
    size = n * (NX + NU)  # unknowns: δx_1 … δx_N, then δu_0 … δu_{N−1}
    hessian, gradient = np.zeros((size, size)), np.zeros(size)
    equations, right = np.zeros((n * NX, size)), np.zeros(n * NX)
    for k in range(n):
        x, u = slice(k * NX, (k + 1) * NX), slice(n * NX + k * NU, n * NX + (k + 1) * NU)
        weights = cost.terminal_weights if k == n - 1 else cost.state_weights * dt
        c, rows = work.policy.constraint_jacobians[k], active[k]
        hessian[x, x] = np.diag(weights) + penalty * c[rows].T @ c[rows]
        gradient[x] = weights * (states[k + 1] - cost.state_goal)
        gradient[x] += c[rows].T @ (multipliers[k] + penalty * work.nominal.constraints[k])[rows]
        hessian[u, u] = np.diag(cost.input_weights * dt)
        gradient[u] = cost.input_weights * dt * (inputs[k] - cost.input_goal)
        jacobian = work.policy.jacobians[k]
        equations[x, x] = np.eye(NX)
        if k > 0:
            equations[x, slice((k - 1) * NX, k * NX)] = -jacobian[:, :NX]
        equations[x, u] = -jacobian[:, NX : NX + NU]
        right[x] = jacobian[:, NX + NU]
    kkt = np.block([[hessian, equations.T], [equations, np.zeros((n * NX, n * NX))]])
    step = np.linalg.solve(kkt, np.concatenate([-gradient, right]))
    moved, turned = step[: n * NX].reshape(n, NX), step[n * NX : size].reshape(n, NU)
    np.testing.assert_allclose(work.trial.states[1:] - states[1:], moved, atol=1e-8)
    np.testing.assert_allclose(work.trial.inputs - inputs, turned, atol=1e-7)
    residuals = work.nominal.constraints + np.einsum("kij,kj->ki", work.policy.constraint_jacobians, moved)
    np.testing.assert_allclose(work.trial.constraints, residuals, atol=1e-8)
    np.testing.assert_array_equal(work.policy.active, multipliers + penalty * work.trial.constraints > 0.0)


def test_compiled_passes_equal_their_plain_twins(problem: Problem) -> None:
    """A horizon of 4 nodes beside the doorframe, backward and forward, run by Python from the same sources."""
    model, start = model_of("paper"), start_state("paper", "violating")
    ends = []
    for plain in (False, True):
        run = (lambda kernel: kernel.py_func) if plain else (lambda kernel: kernel)
        work = workspace_at(problem, np.tile(start, (51, 1)), np.tile(model.hover_input, (50, 1)))
        work = work._replace(
            nominal=type(work.nominal)(*[field[: 5 - (i > 0)] for i, field in enumerate(work.nominal)]),
            trial=type(work.trial)(*[field[: 5 - (i > 0)] for i, field in enumerate(work.trial)]),
            policy=type(work.policy)(*[field[:4] for field in work.policy]),
        )
        work.policy.factors[:] = np.diag(np.sqrt(work.weights.input))
        work.trial.states[0] = start
        assert run(forward.forward)(problem.model, work, 0, 0.0, True, 0) == backward.DONE
        work = work.swapped()
        run(backward.linearize)(problem.model, work)
        riccati.terminal_value(work)
        assert run(backward.backward)(work, 3, 0.0, True, False) == backward.DONE
        assert work.policy.active.any()
        work.trial.states[0] = start
        assert run(forward.forward)(problem.model, work, 0, 1.0, True, 0) == backward.DONE
        ends.append((work.trial, work.policy, work.scratch.result.copy()))
    for compiled, plain_twin in zip(
        (*ends[0][0], *ends[0][1], ends[0][2]), (*ends[1][0], *ends[1][1], ends[1][2]), strict=True
    ):
        np.testing.assert_allclose(compiled, plain_twin, rtol=1e-7, atol=1e-9)


def test_cost_of_a_rollout_is_that_of_the_cost_function(problem: Problem, work: Workspace) -> None:
    work = work.swapped()
    expected = problem.cost.total(work.trial.states, work.trial.inputs, problem.time_step)
    assert forward.total_cost(work) == pytest.approx(expected, rel=1e-13)
    assert forward.total_cost.py_func(work) == pytest.approx(expected, rel=1e-13)
