"""Inputs that cost nothing by themselves: the cost of the states that they lead to decides."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from doorman import ocp
from doorman.ocp.solvers.options import Hessian


@pytest.mark.slow  # has kernels of its own
@pytest.mark.parametrize("hessian", ["both", "gauss-newton"])
def test_an_input_without_weight_goes_to_its_bound_until_the_goal_is_reached(hessian: Hessian) -> None:
    """ẋ = u, |u| ≤ 1, from 1: x falls by 0.1 a step. A second input, which only a term curves, is 0.5."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u", 2)
    problem = ocp.SymbolicModel(x, u, u[0] + 0.0 * u[1]).problem(
        20, 0.1, ocp.QuadraticCost([1.0], [1.0], [0.0, 0.0], [0.0], [0.0, 0.0]),
        bounds=ocp.Bounds(input_lower=[-1.0, -2.0], input_upper=[1.0, 2.0]),
        costs=[ocp.Residual("aside", u[1] - 0.5, [1.0])],
    )  # fmt: skip
    found = ocp.Hybrid(problem, ocp.SolverOptions(hessian=hessian)).solve([1.0])
    fall = np.maximum(1.0 - 0.1 * np.arange(21), 0.0)
    assert found.status is ocp.PlanStatus.CONVERGED
    np.testing.assert_allclose(found.states[:, 0], fall, atol=2e-3)  # one bound is reached without a multiplier
    np.testing.assert_allclose(found.inputs[:, 1], 0.5, atol=1e-4)
    assert found.cost == pytest.approx(0.05 * (fall[:20] ** 2).sum(), rel=1e-5)
