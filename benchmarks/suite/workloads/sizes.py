"""Longer horizons and longer arms: does it still converge, and what does a node cost?"""

from __future__ import annotations

from typing import Any

from suite.session import Session
from suite.task import Task
from suite.tasks import arm, paper
from suite.workloads.cold import QUICK_STATES, STATES, Case, along_loop, compare

HORIZONS = (20, 50, 100, 200, 500)
"""N, steps of 0.02 s."""

ARMS = (2, 3, 4, 5, 6, 7)
"""Joints."""

SOLVERS = ("doorman", "ipopt", "fatrop", "hpipm_tuned", "acados_door", "csqp")
"""Those that go along; the others are seen on the paper's door."""

QUICK_SOLVERS = ("doorman", "fatrop")

EVERY = 10
"""The others solve every tenth of doorman's states: they are slow."""


def measure_horizons(session: Session) -> dict[str, Any]:
    """The paper's door with horizons from 0.4 to 10 s, from hover inputs; states of the loop with N = 50."""
    rows: list[dict[str, Any]] = []
    states = along_loop(session, paper(), _count(session))
    for horizon in (50, 500) if session.quick else HORIZONS:
        task = paper(horizon_steps=horizon)
        cases = [Case(case.index, case.state, session.judge(task).optimum(case.state)) for case in states]
        rows += [{"horizon": horizon, **row} for row in _all(session, task, cases)]
        session.release(task)
    return {"rows": rows}


def measure_arms(session: Session) -> dict[str, Any]:
    """The paper's door with arms of 2 to 7 joints, states along their own loops."""
    rows: list[dict[str, Any]] = []
    for joints in (2, 7) if session.quick else ARMS:
        task = arm(joints, session.scratch("urdf"))
        rows += [{"joints": joints, **row} for row in _all(session, task, along_loop(session, task, _count(session)))]
        session.release(task)
    return {"rows": rows}


def _count(session: Session) -> int:
    return QUICK_STATES if session.quick else STATES


def _all(session: Session, task: Task, cases: list[Case]) -> list[dict[str, Any]]:
    """Every state by doorman, some of them by everybody in turn."""
    names = QUICK_SOLVERS if session.quick else SOLVERS
    some: list[dict[str, Any]] = compare(session, task, cases[::EVERY], repeats=2, names=names)["rows"]
    rest = [case for k, case in enumerate(cases) if k % EVERY]
    alone: list[dict[str, Any]] = compare(session, task, rest, repeats=2, names=("doorman",))["rows"]
    return some + alone
