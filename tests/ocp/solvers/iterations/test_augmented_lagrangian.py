"""Parts of the augmented Lagrangian iterations, each against numpy: measure, cost, linearisation, filter, steps."""

from __future__ import annotations

import numpy as np
import pytest
from dense_horizon import DenseHorizon
from double_integrator import Variant
from finite_differences import central_difference
from numpy.typing import NDArray
from random_horizon import N, cart, door, random_horizon

from doorman.numba_types.handles import Handle, held
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.iterations.filter import FILTER_SIZE, MARGIN, is_new, remember
from doorman.ocp.solvers.iterations.nominal import (
    linearize,
    measure,
    measure_nominal,
    move,
    save,
    take_multipliers,
    total_cost,
)
from doorman.ocp.solvers.memory.result import RESULT
from doorman.ocp.solvers.memory.workspace import Workspace

Array = NDArray[np.float64]


@pytest.fixture(params=[cart, door])
def problem(request: pytest.FixtureRequest) -> Problem:
    return request.param()


def test_measure_finds_the_worst_row_of_every_kind(rng: np.random.Generator) -> None:
    """Rows are numbered h, h_N, g, then the finite bounds; the start itself is not measured."""
    problem = cart()
    firsts = {"rows": 0, "end_rows": 2, "input_rows": 3}
    for _ in range(60):
        work = random_horizon(problem, rng)
        work.linear.jacobians[:, :, problem.nx] = 0.1 * rng.normal(size=(N, problem.nx))
        kind = rng.integers(4)
        if kind < 3:
            values = getattr(work.nominal, tuple(firsts)[kind])
            values[tuple(rng.integers(size) for size in values.shape)] += 6.0
        found = []
        for name, index, _, value, _ in DenseHorizon(work).rows():
            if len(index) == 3:
                number = index[1] + problem.nx * (name == "inputs")
                matches = (work.program.bounded == number) & (work.program.side == index[2])
                row = 4 + int(np.flatnonzero(matches)[0])
            else:
                row = firsts[name] + index[-1]
            node = N if name == "end_rows" else index[0] + (name in ("rows", "states"))
            found.append((value, node, row))
        result = work.result
        measure(held(work), work.nominal)
        assert (result[RESULT.VIOLATION], result[RESULT.NODE], result[RESULT.ROW]) == max(found)
        total = sum(max(value, 0.0) for value, _, _ in found)
        assert result[RESULT.INFEASIBILITY] == pytest.approx(total, rel=1e-12)
        assert result[RESULT.DEFECT] == 0.0
        measure_nominal(held(work))
        defects = np.abs(work.linear.jacobians[:, :, problem.nx])
        assert result[RESULT.DEFECT] == defects.max()
        assert result[RESULT.INFEASIBILITY] == pytest.approx(total + defects.sum(), rel=1e-12)


def test_what_is_not_finite_is_infinitely_infeasible(rng: np.random.Generator) -> None:
    for name in ("rows", "input_rows", "end_rows"):
        work = random_horizon(cart(), rng)
        getattr(work.nominal, name)[0] = np.nan
        measure(held(work), work.nominal)
        assert work.result[RESULT.INFEASIBILITY] == np.inf


def test_total_cost_is_the_costs_own(problem: Problem, rng: np.random.Generator) -> None:
    work = random_horizon(problem, rng)
    expected = problem.cost.total(work.nominal.states, work.nominal.inputs, problem.time_step)
    reached = total_cost(Handle(problem.model), held(work), work.nominal)
    assert reached == pytest.approx(expected, rel=1e-13)


def test_linearisation_of_everything_along_a_trajectory(problem: Problem, rng: np.random.Generator) -> None:
    """Values, defects and slopes of dynamics and rows of all kinds, against finite differences; padding stays zero."""
    work, model, nx, nu = random_horizon(problem, rng), Handle(problem.model), problem.nx, problem.nu
    for array in work.linear:
        array[:] = 0.0
    states, inputs = work.nominal.states, work.nominal.inputs
    states *= 0.4
    linearize(model, held(work))

    def value(function: str, size: int, *arguments: Array) -> Array:
        out = np.empty(size)
        getattr(functions, function)(problem.model, *(each.copy() for each in arguments), out)
        return out

    def both(function: str, size: int, k: int) -> Array:
        z = np.concatenate([states[k], inputs[k]])
        return central_difference(lambda z: value(function, size, z[:nx], z[nx:]), z)

    linear, mixed = work.linear, [*range(nx), *range(nx + 1, nx + 1 + nu)]
    for k in range(N):
        np.testing.assert_allclose(linear.jacobians[k][:, mixed], both("step", nx, k), atol=1e-7)
        defect = value("step", nx, states[k], inputs[k]) - states[k + 1]
        np.testing.assert_allclose(linear.jacobians[k, :, nx], defect, atol=1e-13)
        nh, ng = problem.n_constraints, problem.n_input_constraints
        np.testing.assert_allclose(work.nominal.rows[k], value("constrain", nh, states[k + 1]), atol=1e-13)
        slopes = central_difference(lambda x: value("constrain", nh, x), states[k + 1])  # noqa: B023
        np.testing.assert_allclose(linear.row_jacobians[k, :, :nx], slopes, atol=1e-7)
        if ng:
            g = value("constrain_input", ng, states[k], inputs[k])
            np.testing.assert_allclose(work.nominal.input_rows[k], g, atol=1e-13)
            np.testing.assert_allclose(
                linear.input_row_jacobians[k][:, mixed], both("constrain_input", ng, k), atol=1e-7
            )
    if problem.n_end_constraints:
        nt = problem.n_end_constraints
        np.testing.assert_allclose(work.nominal.end_rows, value("constrain_end", nt, states[N]), atol=1e-13)
        slopes = central_difference(lambda x: value("constrain_end", nt, x), states[N])
        np.testing.assert_allclose(linear.end_row_jacobians[:, :nx], slopes, atol=1e-7)
    for array in (linear.jacobians, linear.input_row_jacobians):
        assert not array[..., nx + 1 + nu :].any()
    for array in (linear.row_jacobians, linear.end_row_jacobians):
        assert not array[..., nx:].any()


# ---------------------------------------------------------------- filter and steps


def test_the_filter_accepts_what_is_better_in_one_respect_than_every_pair_before() -> None:
    pairs, noise = np.zeros((FILTER_SIZE, 2)), 1e-11

    def good(infeasibility: float, cost: float) -> bool:
        return bool(is_new(pairs, count, infeasibility, cost, MARGIN, noise))

    count = 0
    assert good(1e9, 1e9)
    for pair in ((1.0, 5.0), (0.1, 8.0)):
        count = remember(pairs, count, *pair)
    assert count == 2
    for pair, expected in (
        ((0.5, 7.0), True), ((2.0, 4.0), True), ((0.05, 99.0), True), ((1.1, 5.1), False), ((0.5, 8.5), False),
        ((np.nan, 0.0), False), ((0.0, np.nan), False), ((np.inf, 0.0), False), ((0.0, -np.inf), False),
    ):  # fmt: skip
        assert good(*pair) == expected, pair
    assert not good(1.0, 5.1), "no progress"
    assert good(1.0, 5.0) and not is_new(pairs, count, 1.0, 5.0, MARGIN, -np.inf), "the same again, but for rounding"


def test_a_full_filter_forgets_its_oldest_pair() -> None:
    pairs, count = np.zeros((FILTER_SIZE, 2)), 0
    for i in range(FILTER_SIZE + 5):
        count = remember(pairs, count, float(i), -float(i))
    assert count == FILTER_SIZE
    np.testing.assert_array_equal(pairs[:, 0], np.arange(5.0, FILTER_SIZE + 5.0))


@pytest.mark.parametrize("scale", [1.0, 0.25])
def test_steps_and_multipliers_go_a_part_of_the_way(scale: float, rng: np.random.Generator) -> None:
    work = random_horizon(cart(), rng)
    for array in (*work.trial[:2], *work.multipliers, *work.proposal):
        array[:] = rng.exponential(size=array.shape)
    work.trial.states[0] = work.nominal.states[0]
    memory, largest = held(work), work.settings.largest_multiplier
    before = [array.copy() for array in (*work.nominal[:2], *work.multipliers)]
    targets = [*work.trial[:2], *work.proposal]
    save(memory)
    move(memory, scale)
    take_multipliers(memory, scale)
    for array, start, target in zip((*work.nominal[:2], *work.multipliers), before, targets, strict=True):
        np.testing.assert_allclose(array, start + scale * (target - start), atol=1e-13)
    assert work.result[RESULT.PRICED_OUT] == 0.0
    work.proposal.rows[2, 0] = 2.0 * largest
    take_multipliers(memory, 1.0)
    assert work.multipliers.rows.max() == largest
    assert work.result[RESULT.PRICED_OUT] == 1.0


def test_variants_share_their_sizes() -> None:
    """What keeps these tests quick: one set of kernels for all carts."""
    wide, narrow = Variant(), Variant(wall=0.5, force=(-1.0, 1.0), boom=(0.0, 0.1))
    assert Workspace.plain(wide.problem()).sizes == Workspace.plain(narrow.problem()).sizes
