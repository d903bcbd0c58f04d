"""Every standard problem from a thousand starts, with far bounds, and from its own solutions."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from standard_problems import NAMES, cases_of, example, judge_of

from doorman import ocp

pytestmark = pytest.mark.slow  # every problem takes a minute or more to compile

STARTS = 1000
_FAR = 100.0
"""Distance of far bounds, in units of 1 + the largest magnitude along a solution."""


@cache
def solver_of(name: str) -> ocp.Hybrid:
    return ocp.Hybrid(example(name).problem())


def far_solver(name: str, solution: ocp.Solution) -> ocp.Hybrid:
    """The same problem, with bounds of every state and input that has none."""
    problem, ends = example(name).problem(), {}
    for kind, values in (("state", solution.states), ("input", solution.inputs)):
        far = _FAR * (1.0 + np.abs(values).max(axis=0))
        for end, sign in (("lower", -1.0), ("upper", 1.0)):
            bound = np.asarray(getattr(problem.bounds, f"{kind}_{end}"))
            ends[f"{kind}_{end}"] = np.where(np.isfinite(bound), bound, sign * far)
    return ocp.Hybrid(replace(problem, bounds=ocp.Bounds(**ends)))


@pytest.mark.parametrize("name", NAMES)
def test_a_thousand_starts_come_back(name: str) -> None:
    """Most with a solution, and all with a status that is true by the judge's own equations."""
    this, solver, usable = example(name), solver_of(name), 0
    for case in cases_of(name, STARTS, seed=13):
        found = this.solve(solver, case.start)
        verdict = judge_of(name).verdict(case, found.states, found.inputs)
        assert verdict.holds == found.usable, found.message()
        usable += found.usable
    assert usable >= 0.99 * STARTS


@pytest.mark.parametrize("name", NAMES)
def test_far_bounds_change_no_result(name: str) -> None:
    this, solver, differ = example(name), solver_of(name), []
    starts = this.starts(10, seed=17)
    far = far_solver(name, this.solve(solver, starts[0]))
    for index, start in enumerate(starts):
        plain, bounded = this.solve(solver, start), this.solve(far, start)
        if plain.status is ocp.PlanStatus.CONVERGED:
            assert bounded.status is ocp.PlanStatus.CONVERGED, (index, bounded.message())
            if abs(bounded.cost / plain.cost - 1.0) > 1e-6:
                differ.append((index, bounded.cost / plain.cost - 1.0))
    assert len(differ) <= 1, differ  # another of several minima


@pytest.mark.parametrize("name", NAMES)
def test_no_solution_gets_worse_as_its_own_guess(name: str) -> None:
    this, solver = example(name), solver_of(name)
    for start in this.starts(5, seed=19):
        found = this.solve(solver, start)
        if not found.usable:
            continue
        for guess in (
            {"inputs": found.inputs},
            {"inputs": found.inputs, "states": found.states},
            {"warm_start": found},
        ):
            again = solver.solve(start, **guess)
            assert again.usable and again.cost <= found.cost + 1e-6 * (1.0 + abs(found.cost)), (list(guess), again)
        this.solve(solver, start)
        for _ in range(3):
            cost = solver.cost
            status, _ = solver.replan(start, elapsed=0.0)
            assert status.usable and solver.cost <= cost + 1e-6 * (1.0 + abs(cost)), status
