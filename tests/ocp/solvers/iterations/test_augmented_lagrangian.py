"""Parts of the augmented Lagrangian iterations, each against numpy: measure, cost, linearisation, filter, steps."""

from __future__ import annotations

import numpy as np
import pytest
from dense_horizon import DenseHorizon
from random_horizon import N, cart, random_horizon

from doorman.numba_types.handles import held
from doorman.ocp.solvers.iterations.filter import MARGIN, Filter, is_new, remember
from doorman.ocp.solvers.iterations.nominal import (
    measure,
    measure_nominal,
    move,
    save,
    take_multipliers,
)


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
        assert (result.violation, result.node, result.row) == max(found)
        total = sum(max(value, 0.0) for value, _, _ in found)
        assert result.infeasibility == pytest.approx(total, rel=1e-12)
        assert result.defect == 0.0
        measure_nominal(held(work))
        defects = np.abs(work.linear.jacobians[:, :, problem.nx])
        assert result.defect == defects.max()
        assert result.infeasibility == pytest.approx(total + defects.sum(), rel=1e-12)


def test_what_is_not_finite_is_infinitely_infeasible(rng: np.random.Generator) -> None:
    for name in ("rows", "input_rows", "end_rows"):
        work = random_horizon(cart(), rng)
        getattr(work.nominal, name)[0] = np.nan
        measure(held(work), work.nominal)
        assert work.result.infeasibility == np.inf


# ---------------------------------------------------------------- filter and steps


def test_the_filter_accepts_what_is_better_in_one_respect_than_every_pair_before() -> None:
    pairs, noise = Filter(), 1e-11

    def good(infeasibility: float, cost: float) -> bool:
        return bool(is_new(pairs, infeasibility, cost, MARGIN, noise))

    assert good(1e9, 1e9)
    for pair in ((1.0, 5.0), (0.1, 8.0)):
        remember(pairs, *pair)
    assert pairs.count == 2
    for pair, expected in (
        ((0.5, 7.0), True), ((2.0, 4.0), True), ((0.05, 99.0), True), ((1.1, 5.1), False), ((0.5, 8.5), False),
        ((np.nan, 0.0), False), ((0.0, np.nan), False), ((np.inf, 0.0), False), ((0.0, -np.inf), False),
    ):  # fmt: skip
        assert good(*pair) == expected, pair
    assert not good(1.0, 5.1), "no progress"
    assert good(1.0, 5.0) and not is_new(pairs, 1.0, 5.0, MARGIN, -np.inf), "the same again, but for rounding"


def test_a_full_filter_forgets_its_oldest_pair() -> None:
    pairs = Filter()
    size = len(pairs.costs)
    for i in range(size + 5):
        remember(pairs, float(i), -float(i))
    assert pairs.count == size
    np.testing.assert_array_equal(pairs.infeasibilities, np.arange(5.0, size + 5.0))
    np.testing.assert_array_equal(pairs.costs, -np.arange(5.0, size + 5.0))


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
    assert not work.result.priced_out
    work.proposal.rows[2, 0] = 2.0 * largest
    take_multipliers(memory, 1.0)
    assert work.multipliers.rows.max() == largest
    assert work.result.priced_out
