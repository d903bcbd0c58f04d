"""The examples of examples/ocp as tasks of the benchmarks, which call no kernel, and IPOPT on them."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[3] / "benchmarks"))

from suite.standard.judge import Judge
from suite.standard.shooting import ProgramSolver, Shooting
from suite.standard.task import NAMES, StandardTask, cases_of, example, task_of

__all__ = ["NAMES", "cases_of", "example", "ipopt_of", "judge_of", "task"]

_TIGHT = {"ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-9, "ipopt.max_iter": 500, "expand": True}


@cache
def task(name: str) -> StandardTask:
    return task_of(name)


@cache
def judge_of(name: str) -> Judge:
    return Judge(task(name))


@cache
def ipopt_of(name: str) -> Any:
    """Verdict on what IPOPT finds for a case, and whether it says that it has converged."""
    program = ProgramSolver(Shooting(task(name)), "ipopt", _TIGHT)

    def solve(case: Any) -> Any:
        program.guess(case)
        program.run()
        return judge_of(name).verdict(case, *program.trajectory()), bool(program.stats["success"])

    return solve
