"""Second derivatives of the Lagrangian: printed kernels against differences of first ones."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
import unicycle

from doorman import ocp
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.defaults import _curve_horizon


@pytest.mark.slow
def test_printed_hessians_are_differences_of_gradients() -> None:
    """Of dynamics, of rows of every kind with their multipliers, and of the costs that are exact anyway."""
    problem, random = unicycle.problem(), np.random.default_rng(0)
    n, nx, nu = problem.horizon, problem.nx, problem.nu
    counts = problem.n_constraints, problem.n_end_constraints, problem.n_input_constraints
    states, inputs = random.uniform(-2.0, 2.0, (n + 1, nx)), random.uniform(-1.0, 1.0, (n, nu))
    costates, prices = random.normal(size=(n, nx)), random.uniform(0.5, 1.0, (n + 1, sum(counts)))
    prices[0, : counts[0]] = prices[:-1, counts[0] : counts[0] + counts[1]] = prices[-1, counts[0] + counts[1] :] = 0.0
    printed, differences = ((np.zeros((n + 1, nx + nu)), np.zeros((n + 1, nx + nu, nx + nu))) for _ in range(2))
    arguments = problem.model, states, inputs, costates, prices, *counts
    functions.curve_horizon(*arguments, *printed)
    _curve_horizon(*arguments, *differences)
    assert np.abs(printed[0] - differences[0]).max() < 1e-12
    bent = np.cos(states[:n, 2]) < 0.0  # `LANE` is not convex there: its expansion leaves that out
    assert bent.any()
    difference = np.abs(printed[1] - differences[1])
    assert difference[:n][~bent].max() < 1e-8 and difference[n].max() < 1e-8
    assert np.abs(printed[1]).max() > 0.1


def test_hessians_are_there_unless_they_are_not_wanted() -> None:
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    model, cost = ocp.SymbolicModel(x, u, u - ca.sin(x)), ocp.QuadraticCost([1.0], [1.0], [1.0], [0.0], [0.0])

    def has_them(**wanted: bool) -> bool:
        return functions.is_implemented(functions.curve_horizon, type(model.problem(5, 0.1, cost, **wanted).model))

    assert has_them() and not has_them(second_derivatives=False)
