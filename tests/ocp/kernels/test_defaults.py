"""What stands in for kernels that a model does not have: nothing for constraints and costs, differences for derivatives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.exceptions import SolverError
from doorman.ocp.kernels import functions

Array = NDArray[np.float64]


class Curved(NamedTuple):
    """Every function bends, so that none of its derivatives is a constant."""

    scale: float


class Bare(NamedTuple):
    """A model with dynamics and nothing else."""

    scale: float


@functions.implement(functions.step, Curved)
@functions.implement(functions.step, Bare)
@kernel
def _step(model: Curved, x: Array, u: Array, out: Array) -> None:
    out[0] = x[0] * x[1] + model.scale * np.sin(u[0])
    out[1] = np.exp(0.5 * x[1]) - u[0] * x[0]


@functions.implement(functions.constrain, Curved)
@kernel
def _constrain(model: Curved, x: Array, h: Array) -> None:
    h[0] = x[0] ** 2 - model.scale * x[1]


@functions.implement(functions.constrain_input, Curved)
@kernel
def _constrain_input(model: Curved, x: Array, u: Array, g: Array) -> None:
    g[0] = x[0] * u[0] - model.scale
    g[1] = np.cos(x[1]) + u[0] ** 2


@functions.implement(functions.constrain_end, Curved)
@kernel
def _constrain_end(model: Curved, x: Array, h: Array) -> None:
    h[0] = model.scale * x[1] ** 3


@functions.implement(functions.stage_cost, Curved)
@kernel
def _stage_cost(model: Curved, x: Array, u: Array) -> float:
    return float(model.scale * x[0] ** 2 * u[0] ** 2 + np.exp(x[1]))


@functions.implement(functions.end_cost, Curved)
@kernel
def _end_cost(model: Curved, x: Array) -> float:
    return float(model.scale * np.cosh(x[0] * x[1]))


@pytest.fixture(params=range(5))
def point(request: pytest.FixtureRequest) -> tuple[Curved, Array, Array]:
    """Model, state and input."""
    rng = np.random.default_rng(request.param)
    return Curved(1.7), rng.uniform(-1.5, 1.5, 2), rng.uniform(-1.5, 1.5, 1)


def test_slopes_of_the_dynamics(point: tuple[Curved, Array, Array]) -> None:
    model, x, u = point
    jacobian = np.full((2, 3), np.nan)
    functions.linearize_step(model, x, u, jacobian)
    exact = [[x[1], x[0], 1.7 * np.cos(u[0])], [-u[0], 0.5 * np.exp(0.5 * x[1]), -x[0]]]
    np.testing.assert_allclose(jacobian, exact, atol=1e-9)


def test_slopes_of_all_rows(point: tuple[Curved, Array, Array]) -> None:
    model, x, u = point
    h, slopes = np.full(1, np.nan), np.full((1, 2), np.nan)
    functions.linearize_constraints(model, x, h, slopes)
    assert h[0] == x[0] ** 2 - 1.7 * x[1]
    np.testing.assert_allclose(slopes, [[2.0 * x[0], -1.7]], atol=1e-9)
    g, slopes = np.full(2, np.nan), np.full((2, 3), np.nan)
    functions.linearize_input_constraints(model, x, u, g, slopes)
    np.testing.assert_allclose(g, [x[0] * u[0] - 1.7, np.cos(x[1]) + u[0] ** 2], rtol=1e-15)
    np.testing.assert_allclose(slopes, [[u[0], 0.0, x[0]], [0.0, -np.sin(x[1]), 2.0 * u[0]]], atol=1e-9)
    h, slopes = np.full(1, np.nan), np.full((1, 2), np.nan)
    functions.linearize_end_constraints(model, x, h, slopes)
    np.testing.assert_allclose(slopes, [[0.0, 5.1 * x[1] ** 2]], atol=1e-8)


def test_expansions_of_own_costs(point: tuple[Curved, Array, Array]) -> None:
    model, x, u = point
    gradient, hessian = np.full(3, np.nan), np.full((3, 3), np.nan)
    functions.expand_stage_cost(model, x, u, gradient, hessian)
    a, b, c = x[0], x[1], u[0]
    np.testing.assert_allclose(gradient, [3.4 * a * c**2, np.exp(b), 3.4 * a**2 * c], atol=1e-8)
    exact = [[3.4 * c**2, 0.0, 6.8 * a * c], [0.0, np.exp(b), 0.0], [6.8 * a * c, 0.0, 3.4 * a**2]]
    np.testing.assert_allclose(hessian, exact, atol=1e-5)
    gradient, hessian = np.full(2, np.nan), np.full((2, 2), np.nan)
    functions.expand_end_cost(model, x, gradient, hessian)
    sinh, cosh = np.sinh(a * b), np.cosh(a * b)
    np.testing.assert_allclose(gradient, [1.7 * b * sinh, 1.7 * a * sinh], atol=1e-8)
    mixed = 1.7 * (sinh + a * b * cosh)
    np.testing.assert_allclose(hessian, [[1.7 * b**2 * cosh, mixed], [mixed, 1.7 * a**2 * cosh]], atol=1e-5)


def test_what_a_model_does_not_have_is_absent() -> None:
    model, x, u, none = Bare(1.0), np.ones(2), np.ones(1), np.empty(0)
    functions.constrain(model, x, none)
    functions.constrain_input(model, x, u, none)
    functions.constrain_end(model, x, none)
    assert functions.stage_cost(model, x, u) == functions.end_cost(model, x) == 0.0


def test_dynamics_cannot_be_absent() -> None:
    class Nothing(NamedTuple):
        scale: float

    with pytest.raises(SolverError, match="no kernel for 'step'"):
        functions.step(Nothing(1.0), np.ones(2), np.ones(1), np.ones(2))
