"""What a solver does to the process that it runs in: it holds no lock while it works, and compiles nothing after construction."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from double_integrator import COST, Variant

from doorman.compilation import kernel_counts
from doorman.exceptions import DimensionError
from doorman.ocp import Cddp, Hybrid, Solver


@pytest.mark.parametrize("method", [Cddp, Hybrid])
def test_other_threads_go_on_during_a_solve(method: type[Solver]) -> None:
    """The solve waits in a kernel for something that only another Python thread does; without it, it gives up after a minute."""
    variant = Variant(speed=0.5)
    solver = method(variant.problem())
    probe = solver._model.content.probe  # a solver copies what it is given
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


@pytest.mark.parametrize("method", [Cddp, Hybrid])
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
        solver.follow(np.array(variant.start), 1.0, max_iterations=3)
    assert kernel_counts() == before


def test_a_run_leaves_in_memory_what_a_solve_copies() -> None:
    variant = Variant(speed=0.5)
    running, solving = Hybrid(variant.problem()), Hybrid(variant.problem())
    status, iterations = running.run(np.array(variant.start))
    solution = solving.solve(variant.start)
    assert (status, iterations) == (solution.status, solution.iterations)
    assert running.cost == solution.cost
    for left, copied in zip(running.trajectory(), (solution.states, solution.inputs), strict=True):
        np.testing.assert_array_equal(left, copied)


def test_another_goal_is_the_problems_from_then_on() -> None:
    variant, goal = Variant(speed=0.5), np.array([0.5, 0.0, 0.2])
    solver = Hybrid(variant.problem())
    solver.solve(variant.start)
    solver.update_goal(goal)
    solution = solver.solve(variant.start)
    told = Hybrid(replace(variant.problem(), cost=replace(COST, state_goal=goal))).solve(variant.start)
    np.testing.assert_array_equal(solution.states, told.states)
    np.testing.assert_array_equal(solution.problem.cost.state_goal, goal)
    assert solver.problem is solution.problem
    assert solution.kkt_residual == told.kkt_residual
    for wrong in (goal[:2], [0.5, np.nan, 0.2]):
        with pytest.raises(DimensionError, match="state_goal"):
            solver.update_goal(wrong)
    np.testing.assert_array_equal(solver.solve(variant.start).states, told.states)
