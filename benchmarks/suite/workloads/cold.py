"""Cold solves from hover inputs to convergence, solver by solver and state by state in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from suite.judge import Judge, Optimum
from suite.process import PeerError, Process
from suite.session import Session
from suite.task import Array, Task
from suite.tasks import limited, paper, random_door

LOOP_STEPS = 150
STATES = 31
"""Along the closed loop."""
QUICK_STATES = 7

DOORS, QUICK_DOORS, STATES_OF_A_DOOR = 5, 1, 6

DOOR_SOLVERS = ("doorman", "ipopt", "fatrop", "hpipm_tuned", "acados_door", "csqp")
"""Those that go along to other doors; every door is generated and compiled anew for them."""


def measure(session: Session) -> dict[str, Any]:
    """The paper's door: 31 states along the closed loop, best of three."""
    task = paper()
    return compare(session, task, along_loop(session, task, QUICK_STATES if session.quick else STATES), repeats=3)


def measure_limited(session: Session) -> dict[str, Any]:
    """The paper's door with limits of inputs, joints and tilt."""
    task = limited()
    names = [name for name in session.names if name not in ("doorman_timed", "hpipm", "hpipm_exact")]
    count = QUICK_STATES if session.quick else STATES
    return compare(session, task, along_loop(session, task, count), repeats=3, names=names)


def measure_doors(session: Session) -> dict[str, Any]:
    """Doors drawn at random, states along their own closed loops."""
    rows: list[dict[str, Any]] = []
    for seed in range(1, 1 + (QUICK_DOORS if session.quick else DOORS)):
        task = random_door(seed, session.scratch("urdf"))
        rows += compare(session, task, along_loop(session, task, STATES_OF_A_DOOR), repeats=3, names=DOOR_SOLVERS)[
            "rows"
        ]
        session.release(task)
    return {"rows": rows}


@dataclass(frozen=True)
class Case:
    """A state to solve from."""

    index: int
    """Step of the loop from which it is."""
    state: Array
    optimum: Optimum | None
    """Where it is known; otherwise the judge looks for it."""


def along_loop(session: Session, task: Task, count: int) -> list[Case]:
    """States spread evenly over a task's closed loop."""
    loop = session.loop(task, LOOP_STEPS)
    return [Case(int(k), loop.states[k], loop.optima[k]) for k in np.linspace(0, LOOP_STEPS, count).astype(int)]


def compare(
    session: Session, task: Task, cases: Sequence[Case], repeats: int, names: Sequence[str] | None = None
) -> dict[str, Any]:
    """Cold solves of some states by some solvers, in turn; by default all that do not only replan."""
    names = [name for name in session.names if name != "doorman_timed"] if names is None else names
    team, judge = session.team(task, names), session.judge(task)
    rows = []
    for turn, case in enumerate(cases):
        optimum = case.optimum or judge.optimum(case.state)
        known = {"task": task.name, "state": case.index, "nodes": task.horizon}
        for process in rotated(team, turn):
            row = solve_cold(process, judge, task, case.state, optimum, repeats)
            rows.append({**known, "solver": process.name, **row})
    return {"rows": rows}


def solve_cold(
    process: Process, judge: Judge, task: Task, state: Array, optimum: Optimum, repeats: int
) -> dict[str, Any]:
    """One state by one solver: best time, and what the answer is worth."""
    try:
        timings, answer = process.cold(task.name, state, repeats)
    except PeerError as error:
        return {"solved": False, "error": str(error)}
    verdict = judge.verdict(state, answer)
    return {
        "seconds": min(timing.on_core for timing in timings), "solved": verdict.solves(optimum), "gap": verdict.gap(optimum),
        "violation": verdict.violation, "defect": verdict.defect, "iterations": answer.iterations,
        "claim": answer.claim, "usable": answer.usable, "callbacks": answer.callbacks,
    }  # fmt: skip


def rotated(team: Sequence[Process], turn: int) -> list[Process]:
    """The team in another order every turn, so that nobody always follows the same rival."""
    start = turn % max(len(team), 1)
    return [*team[start:], *team[:start]]
