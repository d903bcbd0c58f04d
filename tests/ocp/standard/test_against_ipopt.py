"""Every standard problem from perturbed starts beside IPOPT, and in closed loop."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from standard_problems import NAMES, cases_of, example, ipopt_of, judge_of

from doorman import ocp

pytestmark = pytest.mark.slow  # every problem takes a minute or more to compile

ROOT = Path(__file__).parents[3]

STARTS = 10


@cache
def solver_of(name: str) -> ocp.Hybrid:
    return ocp.Hybrid(example(name).problem())


@pytest.mark.parametrize("name", NAMES)
def test_as_good_as_ipopt_from_the_same_guess(name: str) -> None:
    this, solver, worse = example(name), solver_of(name), []
    for index, case in enumerate(cases_of(name, STARTS, seed=7)):
        (best, success), found = ipopt_of(name)(case), this.solve(solver, case.start)
        verdict = judge_of(name).verdict(case, found.states, found.inputs)
        assert found.usable and verdict.holds, (index, found.message())
        assert verdict.cost == pytest.approx(found.cost, rel=1e-9)
        gap = verdict.cost / best.cost - 1.0
        if success and found.status is ocp.PlanStatus.CONVERGED and abs(gap) < 1e-3:
            assert abs(gap) < 1e-6, (index, gap)  # the same minimum
        if success and gap > 1e-4:
            worse.append((index, gap))
    assert len(worse) <= STARTS // 10, worse


@pytest.mark.parametrize("name", NAMES)
def test_closed_loops_reach_the_goal(name: str) -> None:
    this, solver = example(name), solver_of(name)
    for seed, start in enumerate(this.starts(2, seed=11)):
        flight = this.fly(solver, start, seed)
        assert this.reached(flight.states), (seed, np.round(flight.states[-1], 3))
        assert sum(not status.flyable for status in flight.statuses) <= 0.02 * this.steps


def test_a_script_says_how_it_went_and_draws(tmp_path: Path) -> None:
    picture = tmp_path / "cart_pole.png"
    ran = subprocess.run(
        [sys.executable, str(ROOT / "examples" / "ocp" / "cart_pole.py"), "--draw", str(picture)], cwd=tmp_path,
        capture_output=True, text=True, timeout=600, check=False, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert "converged" in ran.stdout and "goal reached" in ran.stdout and "replans: median" in ran.stdout
    assert picture.stat().st_size > 1000
