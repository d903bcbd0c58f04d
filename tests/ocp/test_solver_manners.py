"""What a solver does to the process that it runs in: it holds no lock while it works, and compiles nothing after construction."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from double_integrator import Variant

from doorman.compilation import kernel_counts
from doorman.ocp import AugmentedLagrangian, Cddp, Hybrid, Solver


@pytest.mark.parametrize("method", [AugmentedLagrangian, Cddp, Hybrid])
def test_other_threads_go_on_during_a_solve(method: type[Solver]) -> None:
    """The solve waits in a kernel for something that only another Python thread does; without it, it gives up after a minute."""
    variant = Variant(speed=0.5)
    solver, probe = method(variant.problem()), variant.probe
    probe[:] = [0.0, 10.0, 0.0, time.monotonic() + 60.0]
    met, over = threading.Event(), threading.Event()

    def answer() -> None:
        while not over.is_set():
            if probe[0] == probe[1]:
                met.set()
                probe[2] = 1.0
                return
            time.sleep(1e-4)

    thread = threading.Thread(target=answer)
    thread.start()
    solution = solver.solve(variant.start)
    over.set()
    thread.join()
    assert met.is_set()
    assert solution.usable


@pytest.mark.parametrize("method", [AugmentedLagrangian, Cddp, Hybrid])
def test_nothing_is_compiled_after_construction(method: type[Solver]) -> None:
    """Easy and hard tasks, another model, real-time iterations; nor is anything loaded from the cache."""
    variant = Variant(start=(0.0, 0.1, 0.0), wall=0.9, reach=0.2, speed=0.6, power=0.9, force=(-0.9, 0.8), dock=0.5)
    solver = method(variant.problem())
    before = kernel_counts()
    for bend in (0.0, 0.5, 3.0):
        solver.update_model(variant.model()._replace(bend=bend))
        solution = solver.solve(variant.start)
        solver.solve(variant.start, solution.inputs, states=solution.states, multipliers=solution.multipliers)
    solver.solve([1.5, 0.0, 0.0], np.ones((30, 2)), max_iterations=3)
    if isinstance(solver, Hybrid):
        solver.follow(np.array(variant.start), 1.0, 2, max_iterations=3)
    assert kernel_counts() == before
