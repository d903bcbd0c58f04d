"""Every solve comes back: from any start, with its costs on any scale, by its deadline, and when it is interrupted."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from double_integrator import Variant
from system import System
from systems import cart_pole

from doorman import ocp
from doorman.ocp.solvers import telling
from doorman.ocp.solvers.batch import solve_all

SCALES = (1e-4, 1e-2, 1e3, 1e6)


def scaled(system: System, scale: float) -> System:
    """The same system at other prices; its solver needs no compilation."""
    cost = system.cost
    weights = {
        name: scale * getattr(cost, name) for name in ("state_weights", "terminal_weights", "input_weights")
    }  # fmt: skip
    return replace(system, cost=replace(cost, **weights))


def finished(call: Any, seconds: float = 120.0) -> Any:
    """What a call returns that would block the tests for ever if it did not come back."""
    out: list[Any] = []
    thread = threading.Thread(target=lambda: out.append(call()), daemon=True)
    thread.start()
    thread.join(seconds)
    assert out, "it does not come back"
    return out[0]


@pytest.fixture(scope="module")
def solver() -> ocp.Hybrid:
    return ocp.Hybrid(cart_pole().problem())


@pytest.mark.parametrize("scale", SCALES)
def test_solves_come_back_at_any_price(scale: float) -> None:
    system = scaled(cart_pole(), scale)
    solver = ocp.Hybrid(system.problem())
    found = finished(lambda: [solver.solve(start, max_iterations=60) for start in system.starts(20, seed=5)])
    assert all(solution.usable for solution in found)


def test_pauses_change_no_bit(solver: ocp.Hybrid, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels that come back as often as they may, also within an iteration, go on as if they had not."""
    for start in cart_pole().starts(5, seed=9):
        solver.forget()
        whole = solver.solve(start)
        monkeypatch.setattr(telling, "_SLICE", 1e-9)
        solver.forget()
        sliced = solver.solve(start)
        monkeypatch.undo()
        assert (sliced.status, sliced.iterations, sliced.cost) == (whole.status, whole.iterations, whole.cost)
        np.testing.assert_array_equal(sliced.inputs, whole.inputs)


class _Interrupted(Exception):
    pass


@contextmanager
def interrupted(solver: ocp.Hybrid) -> Iterator[None]:
    """A signal comes during the first linearisation of what runs inside, and has to come out of it."""
    probe = solver._model.content.probe
    probe[:] = [0.0, 10.0, 0.0, time.monotonic() + 60.0]

    def interrupt(number: int, frame: object) -> None:
        raise _Interrupted

    def answer() -> None:
        while probe[0] != probe[1]:
            time.sleep(1e-3)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGUSR1)
        time.sleep(3.0 * telling._SLICE)
        probe[2] = 1.0

    before = signal.signal(signal.SIGUSR1, interrupt)
    thread = threading.Thread(target=answer)
    try:
        thread.start()
        with pytest.raises(_Interrupted):
            yield
    finally:
        thread.join()
        signal.signal(signal.SIGUSR1, before)
        probe[1] = -1.0


def test_an_interrupt_ends_a_solve_between_two_iterations() -> None:
    """The solve does not go on to its end before Python sees the signal."""
    variant = Variant(speed=0.5)
    solver = ocp.Hybrid(variant.problem())
    with interrupted(solver):
        solver.solve(variant.start)
    assert solver._work.result.iterations == 1
    status, _ = solver.replan(np.array(variant.start))  # there is nothing to follow: a solve from nothing
    assert status is ocp.PlanStatus.CONVERGED


@pytest.mark.parametrize("iterations", [1, 40])
def test_an_interrupt_of_a_replan_leaves_the_trajectory_before_it(iterations: int) -> None:
    variant = Variant(speed=0.5)
    solver = ocp.Hybrid(variant.problem())
    solver.solve(variant.start)
    states, inputs = solver.trajectory()
    elsewhere = np.array(variant.start) + [0.3, 0.1, 0.0]
    with interrupted(solver):
        solver.replan(elsewhere, elapsed=0.0, iterations=iterations)
    for left, before in zip(solver.trajectory(), (states, inputs), strict=True):
        np.testing.assert_allclose(left, before, atol=1e-12)
    assert solver._started and np.abs(solver._work.policy.gains).max() > 0.0
    status, _ = solver.replan(elsewhere, elapsed=0.0, iterations=iterations)
    assert status.usable
    np.testing.assert_allclose(solver.trajectory()[0][0], elsewhere)


def test_an_interrupt_ends_what_other_threads_solve() -> None:
    """A batch whose caller is interrupted neither begins what waits, nor goes on with what runs."""
    variant = Variant(speed=0.5)
    solver, begun = ocp.Hybrid(variant.problem()), []

    class Impatient(Exception):
        pass

    class Starts(list[tuple[np.ndarray]]):
        def __iter__(self) -> Any:
            yield (np.array(variant.start),)
            while not begun:
                time.sleep(1e-3)
            raise Impatient

    def solve(worker: ocp.Hybrid, start: np.ndarray) -> ocp.Solution:
        begun.append(worker)
        while not worker._teller._stopping:
            time.sleep(1e-3)
        return worker.solve(start)

    with pytest.raises(Impatient):
        solve_all(solver, Starts([(np.array(variant.start),)] * 2), solve, 1)
    assert len(begun) == 1 and not solver._teller._stopping
