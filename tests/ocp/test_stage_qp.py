"""ProxQP on one node's quadratic program: optimality conditions, and quick refusal of what has no solution."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.ocp.stage_qp import StageQpSolver
from doorman.ocp.workspace import StageQp


def random_qp(rng: np.random.Generator, n: int, m: int) -> StageQp:
    """Strictly convex, with a strictly feasible point and several rows that its free minimum violates."""
    root = rng.normal(size=(n, n))
    jacobian = rng.normal(size=(m, n))
    inside = rng.normal(size=n)
    return StageQp(
        hessian=root @ root.T + 0.1 * np.eye(n),
        gradient=5.0 * rng.normal(size=n),
        jacobian=jacobian,
        constraints=-jacobian @ inside - rng.uniform(0.01, 1.0, m),
        step=np.zeros(n),
        multipliers=np.zeros(m),
    )


def assert_optimal(qp: StageQp) -> None:
    """Stationarity, feasibility, signs and complementarity."""
    residual = qp.constraints + qp.jacobian @ qp.step
    gradient = qp.hessian @ qp.step + qp.gradient + qp.jacobian.T @ qp.multipliers
    np.testing.assert_allclose(gradient, 0.0, atol=1e-8)
    assert residual.max() <= 1e-8
    assert (qp.multipliers >= 0.0).all()
    np.testing.assert_allclose(qp.multipliers * residual, 0.0, atol=1e-5 * (1.0 + qp.multipliers.max()))


@pytest.mark.parametrize(("n", "m"), [(8, 6), (6, 4), (11, 9), (3, 8)])
def test_optimality_conditions(n: int, m: int, rng: np.random.Generator) -> None:
    solver, active = StageQpSolver(n, m), 0
    for _ in range(30):
        qp = random_qp(rng, n, m)
        assert solver.solve(qp)
        assert_optimal(qp)
        active += int((qp.multipliers > 1e-6).sum())
    assert active > 30


def test_small_rows_are_no_contradiction(rng: np.random.Generator) -> None:
    """Both rows ask for v ≤ something; ProxQP's default tolerance of infeasibility refuses this one."""
    rail = StageQp(
        np.array([[0.01]]), np.zeros(1), np.array([[0.005], [0.1]]), np.array([0.015, 3e-13]), np.zeros(1), np.zeros(2)
    )
    assert StageQpSolver(1, 2).solve(rail)
    np.testing.assert_allclose(rail.step, -3.0, atol=1e-5)
    for _ in range(50):
        qp = random_qp(rng, 8, 6)
        scales = 10.0 ** rng.uniform(-4.0, 0.0, 6)
        qp.jacobian[:] *= scales[:, None]
        qp.constraints[:] *= scales
        assert StageQpSolver(8, 6).solve(qp)
        assert (qp.constraints + qp.jacobian @ qp.step).max() <= 1e-9


def test_no_active_row_is_a_newton_step(rng: np.random.Generator) -> None:
    qp = random_qp(rng, 8, 6)
    qp.constraints[:] = -1e3
    assert StageQpSolver(8, 6).solve(qp)
    np.testing.assert_allclose(qp.step, -np.linalg.solve(qp.hessian, qp.gradient), atol=1e-9)
    np.testing.assert_array_equal(qp.multipliers, 0.0)


@pytest.mark.parametrize("field", ["hessian", "gradient", "jacobian", "constraints"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_data_that_are_not_finite_are_refused(field: str, value: float, rng: np.random.Generator) -> None:
    solver = StageQpSolver(8, 6)
    good = random_qp(rng, 8, 6)
    assert solver.solve(good)
    qp = random_qp(rng, 8, 6)
    getattr(qp, field)[-1] = value
    assert not solver.solve(qp)
    np.testing.assert_array_equal(qp.step, 0.0)
    assert solver.solve(good)
    assert_optimal(good)


def test_rows_that_contradict_each_other_are_refused(rng: np.random.Generator) -> None:
    """v_1 ≤ −1 and v_1 ≥ 1; the solver works again afterwards."""
    solver = StageQpSolver(8, 6)
    qp = random_qp(rng, 8, 6)
    qp.jacobian[:2] = 0.0
    qp.jacobian[0, 0], qp.jacobian[1, 0] = 1.0, -1.0
    qp.constraints[:2] = 1.0
    for _ in range(3):
        assert not solver.solve(qp)
    for _ in range(3):
        qp = random_qp(rng, 8, 6)
        assert solver.solve(qp)
        assert_optimal(qp)


def test_a_row_that_no_input_moves_decides_alone(rng: np.random.Generator) -> None:
    solver = StageQpSolver(8, 6)
    qp = random_qp(rng, 8, 6)
    qp.jacobian[3] = 0.0
    qp.constraints[3] = -0.1
    assert solver.solve(qp)
    assert_optimal(qp)
    qp.constraints[3] = 0.1
    assert not solver.solve(qp)
