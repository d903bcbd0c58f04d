"""One node of a Riccati sweep, generated for its sizes, against dense algebra for many sizes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.ocp import Problem, QuadraticCost
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.node_elimination import eliminate_inputs, factors_width
from doorman.ocp.solvers.sweeps.sized import shape_of
from doorman.ocp.solvers.sweeps.tiles import WIDTH

Array = NDArray[np.float64]

N, STEP = 3, 0.07
SIZES = [
    (1, 1, 0), (1, 1, 1), (2, 1, 0), (3, 2, 1), (3, 5, 2), (7, 7, 0), (4, 4, 4), (9, 8, 4), (12, 9, 0), (15, 1, 0), (18, 8, 0),
    (20, 12, 12),
]  # fmt: skip
"""States, inputs, and how many of the last ones are integrators."""


@kernel
def _eliminate(
    sizes: Any, k: int, step: float, jacobians: Array, value: Array, base_x: Array, base_u: Array, gains: Array,
    factors: Array, values: Array, rows: Array, scaled: Array,
) -> bool:  # fmt: skip
    return bool(
        eliminate_inputs(sizes, k, step, jacobians, value, base_x, base_u, gains, factors, values, rows, scaled)
    )  # fmt: skip


def eliminate(work: Workspace, k: int) -> bool:
    node = work.node
    return _eliminate(
        shape_of(work.sizes), k, work.weights.time_step, work.linear.jacobians, node.value, node.base_x, node.base_u,
        work.policy.gains, work.policy.factors, work.policy.values, node.rows, node.scaled,
    )  # fmt: skip


def problem_of(nx: int, nu: int, integrators: int) -> Problem:
    """Sizes alone; nothing of it is evaluated."""
    cost = QuadraticCost(np.ones(nx), np.ones(nx), np.ones(nu), np.zeros(nx), np.zeros(nu))
    return Problem(None, N, STEP, cost, integrators=integrators)


def random_node(nx: int, nu: int, m: int, rng: np.random.Generator) -> Workspace:
    """Everything random; of integrators, only what is theirs. Whatever is not written stays NaN."""
    work = Workspace.plain(problem_of(nx, nu, m))
    for array in (*work.policy, work.node.rows, work.node.scaled):
        array[:] = np.nan
    s, v = nx - m, nu - m
    jacobians = rng.normal(size=(N, nx, nx + 1 + nu))
    if m:
        jacobians[:, :s, s:nx] = 0.0
        jacobians[:, :s, nx + 1 + v :] = 0.0
        jacobians[:, s:] = np.hstack(
            [np.zeros((m, s)), np.eye(m), np.zeros((m, 1 + v)), STEP * np.eye(m)]
        )  # fmt: skip
    work.linear.jacobians[:, :, : nx + 1 + nu] = jacobians
    root = rng.normal(size=(nx, nx + 2))
    work.node.value[:, :nx], work.node.value[:, nx] = root @ root.T, rng.normal(size=nx)
    root = rng.normal(size=(nx + nu, nx + nu + 2))
    hessian, gradient = root @ root.T + 0.1 * np.eye(nx + nu), rng.normal(size=nx + nu)
    work.node.base_x[:, :nx], work.node.base_x[:, nx] = hessian[:nx, :nx], gradient[:nx]
    work.node.base_u[:, :nx], work.node.base_u[:, nx] = hessian[nx:, :nx], gradient[nx:]
    work.node.base_u[:, nx + 1 : nx + 1 + nu] = hessian[nx:, nx:]
    return work


def model_of_node(work: Workspace, k: int, nx: int, nu: int) -> tuple[Array, Array]:
    """Hessian and gradient in [δx, δu] of the node's cost plus the value after the linearised step."""
    jacobian, value, base_x, base_u = work.linear.jacobians[k], work.node.value, work.node.base_x, work.node.base_u
    by_both = np.hstack([jacobian[:, :nx], jacobian[:, nx + 1 : nx + 1 + nu]])
    own = np.vstack(
        [np.hstack([base_x[:, :nx], base_u[:, :nx].T]), base_u[:, [*range(nx), *range(nx + 1, nx + 1 + nu)]]]
    )
    gradient = np.concatenate([base_x[:, nx], base_u[:, nx]])
    ahead = value[:, :nx] @ jacobian[:, nx] + value[:, nx]
    return own + by_both.T @ value[:, :nx] @ by_both, gradient + by_both.T @ ahead


@pytest.mark.parametrize(("nx", "nu", "m"), SIZES)
def test_value_and_policy_are_those_of_the_dense_model(nx: int, nu: int, m: int, rng: np.random.Generator) -> None:
    for k in range(N):
        work = random_node(nx, nu, m, rng)
        hessian, gradient = model_of_node(work, k, nx, nu)
        assert eliminate(work, k)
        by_input, mixed = hessian[nx:, nx:], hessian[nx:, :nx]
        policy = -np.linalg.solve(by_input, np.column_stack([mixed, gradient[nx:]]))
        scale = np.abs(hessian).max()
        close = {"rtol": 1e-9, "atol": 1e-11 * scale}
        np.testing.assert_allclose(work.policy.gains[k, :, : nx + 1], policy, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(work.node.value[:, :nx], hessian[:nx, :nx] + mixed.T @ policy[:, :nx], **close)
        np.testing.assert_allclose(work.node.value[:, nx], gradient[:nx] + mixed.T @ policy[:, nx], **close)
        for other in {*range(N)} - {k}:
            assert all(
                np.isnan(array[other]).all() for array in (work.policy.gains, work.policy.factors, work.policy.values)
            )


@pytest.mark.parametrize(("nx", "nu", "m"), SIZES)
def test_factors_and_rows_are_of_that_elimination(nx: int, nu: int, m: int, rng: np.random.Generator) -> None:
    """Q_uu = Uᵀ D U; R = D L are the rows on the way, U⁻ᵀ [Q_ux | Q_u]; the corrections of other kernels build on them."""
    work = random_node(nx, nu, m, rng)
    hessian, gradient = model_of_node(work, 1, nx, nu)
    assert eliminate(work, 1)
    factors = work.policy.factors[1, :, :nu]
    upper, diagonal = np.triu(factors, 1) + np.eye(nu), np.diag(factors)
    assert (diagonal > 0.0).all()
    np.testing.assert_allclose(upper.T @ np.diag(diagonal) @ upper, hessian[nx:, nx:], rtol=1e-10, atol=1e-11)
    rows = np.linalg.solve(upper.T, np.column_stack([hessian[nx:, :nx], gradient[nx:]]))
    np.testing.assert_allclose(work.node.rows[:, : nx + 1], rows, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(work.node.scaled[:, : nx + 1], rows / diagonal[:, None], rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize(("nx", "nu", "m"), [(3, 2, 1), (9, 8, 4)])
def test_a_node_that_is_not_convex_is_refused(nx: int, nu: int, m: int, rng: np.random.Generator) -> None:
    for row in range(nu):
        work = random_node(nx, nu, m, rng)
        work.node.base_u[row, nx + 1 + row] -= 1e3
        assert not eliminate(work, 0)
    work = random_node(nx, nu, m, rng)
    work.node.value[0, 0] = np.nan
    assert not eliminate(work, 0)


def test_rows_are_padded_to_the_vector_width() -> None:
    for nx, nu, m in SIZES:
        sizes = Workspace.plain(problem_of(nx, nu, m)).sizes
        assert sizes.narrow % WIDTH == sizes.wide % WIDTH == 0
        assert nx + 1 <= sizes.narrow <= nx + WIDTH
        assert nx + 1 + nu <= sizes.wide <= nx + nu + WIDTH
        assert nu <= factors_width(nu) < nu + 8
