"""Warm starts from saved solutions, many solves on many threads, copies, and a callback that looks on."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from system import System
from systems import parking

from doorman import ocp
from doorman.exceptions import DimensionError

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def system() -> System:
    return parking()


@pytest.fixture(scope="module")
def solver(system: System) -> ocp.Hybrid:
    return ocp.Hybrid(system.problem())


def _same(first: ocp.Solution, second: ocp.Solution) -> bool:
    pairs = ((first.states, second.states), (first.inputs, second.inputs), (first.gains, second.gains))
    return all(np.array_equal(*pair) for pair in (*pairs, *zip(first.multipliers, second.multipliers, strict=True)))


def test_a_saved_solution_is_a_warm_start(system: System, solver: ocp.Hybrid) -> None:
    """A few iterations instead of many, and none of the search."""
    start = np.asarray(system.start)
    cold = solver.solve(start)
    loaded = pickle.loads(pickle.dumps(cold))
    assert _same(cold, loaded) and loaded.kkt_residual == cold.kkt_residual
    warm = solver.solve(start + 1e-3, warm_start=loaded)
    reference = solver.solve(start + 1e-3)
    assert warm.status is ocp.PlanStatus.CONVERGED and warm.iterations <= 5 < cold.iterations
    assert warm.cost == pytest.approx(reference.cost, rel=1e-6)
    with pytest.raises(DimensionError, match="warm_start"):
        solver.solve(start, cold.inputs, warm_start=cold)


@pytest.mark.parametrize("threads", [1, 3])
def test_a_batch_has_the_bits_of_single_solves(system: System, solver: ocp.Hybrid, threads: int) -> None:
    starts = list(system.starts(9, seed=5))
    alone = [ocp.Hybrid(system.problem()).solve(start) for start in starts]
    together = solver.solve_batch(starts, threads=threads)
    assert all(isinstance(each, ocp.Solution) and _same(each, one) for each, one in zip(together, alone, strict=True))
    again = solver.solve_batch(starts, threads=threads, warm_starts=alone)
    assert all(isinstance(each, ocp.Solution) and each.iterations <= 3 for each in again)
    with pytest.raises(DimensionError, match="states"):
        solver.solve_batch([*starts, [0.0]])
    with pytest.raises(DimensionError, match="warm_starts"):
        solver.solve_batch(starts, warm_starts=alone[1:])
    assert solver.solve_batch(np.zeros((0, 4))) == []


def test_a_failure_in_a_batch_loses_no_other() -> None:
    def step(x: np.ndarray, u: np.ndarray) -> list[float]:
        if x[0] > 2.0:
            raise ValueError("too far")
        return [x[0] + 0.1 * u[0]]

    cost = ocp.QuadraticCost([1.0], [1.0], [1.0], [0.0], [0.0])
    solver = ocp.Hybrid(ocp.PythonModel(step).problem(cost, 5, 0.1))
    first, second, third = solver.solve_batch([[1.0], [3.0], [-1.0]], threads=2)
    assert isinstance(second, ValueError) and "too far" in str(second)
    assert isinstance(first, ocp.Solution) and first.usable and isinstance(third, ocp.Solution) and third.usable
    assert first.cost == pytest.approx(third.cost)


@pytest.mark.parametrize("name", ["both", "gauss-newton", "exact"])
def test_a_callback_sees_every_iteration_and_changes_nothing(system: System, name: str) -> None:
    start, seen = np.asarray(system.start), []
    options = ocp.SolverOptions(hessian=name)  # type: ignore[arg-type]
    silent = ocp.Hybrid(system.problem(), options).solve(start)
    told = ocp.Hybrid(system.problem(), options).solve(start, callback=seen.append)
    assert _same(silent, told) and silent.iterations == told.iterations
    assert {each.phase for each in seen} >= {"interior" if name == "exact" else "fast"}
    last = seen[-1]
    assert last.cost == pytest.approx(told.cost, rel=1e-4) and last.violation < 1e-4 and last.defect < 1e-4
    assert all(np.isfinite([each.cost, each.violation, each.defect, each.step]).all() for each in seen)
    counts = [each.iteration for each in seen]
    assert all(now in (before + 1, before, 1) for before, now in zip(counts, counts[1:], strict=False))


def test_a_callback_ends_a_solve_with_an_honest_status(system: System) -> None:
    solver, start = ocp.Hybrid(system.problem()), np.asarray(system.start)
    early = solver.solve(start, callback=lambda each: each.iteration == 2)
    assert early.iterations == 2 and not early.usable and early.violation > 1e-6
    good = solver.solve(start)
    late = solver.solve(start, good.inputs, states=good.states, callback=lambda each: each.phase == "interior")
    assert late.status is ocp.PlanStatus.CONVERGED  # the fast iterations had ended
    with pytest.raises(ZeroDivisionError):
        solver.solve(start, callback=lambda each: 1 // 0)
    assert solver.solve(start).status is ocp.PlanStatus.CONVERGED
