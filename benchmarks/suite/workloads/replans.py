"""One iteration from the shifted previous plan, along closed loops without and with noise."""

from __future__ import annotations

from typing import Any

from suite.judge import Judge
from suite.process import PeerError, Process
from suite.session import Session
from suite.states import Loop
from suite.task import Task
from suite.tasks import paper
from suite.workloads.cold import LOOP_STEPS, rotated

PASSES = 10
"""Times that everybody flies the loop."""

DISTURBED_LOOPS = 5

SOLVERS = ("doorman", "doorman_timed", "hpipm", "hpipm_tuned", "acados_door", "csqp")
"""Those that can."""


def measure(session: Session) -> dict[str, Any]:
    """The paper's door without disturbance: 150 steps, several times over, and once in turn after every single step."""
    task = paper()
    loop = session.loop(task, LOOP_STEPS)
    rows: list[dict[str, Any]] = []
    for turn in range(2 if session.quick else PASSES):
        rows += fly(session, task, loop, turn, f"pass {turn}")
    return {"rows": rows, "cold_caches": fly(session, task, loop, 0, "cold caches", block=1)}


def measure_disturbed(session: Session) -> dict[str, Any]:
    """The same with noise on the state after every step, another seed every time."""
    task = paper()
    rows: list[dict[str, Any]] = []
    for seed in range(1 if session.quick else DISTURBED_LOOPS):
        rows += fly(session, task, session.loop(task, LOOP_STEPS, seed), seed, f"noise {seed}")
    return {"rows": rows}


def fly(
    session: Session, task: Task, loop: Loop, turn: int, name: str, block: int = LOOP_STEPS
) -> list[dict[str, Any]]:
    """All solvers along one loop.

    Args:
        session: The session.
        task: The task.
        loop: Its states.
        turn: Who begins.
        name: Of this flight, for the rows.
        block: Steps that a solver makes in a row before the next one has its turn. With one, its data are out of the cache
            whenever it is called.
    """
    team, judge, failed = session.team(task, SOLVERS), session.judge(task), dict[str, str]()
    rows = []
    for count, first in enumerate(range(1, len(loop.states), block)):
        steps = range(first, min(first + block, len(loop.states)))
        for process in rotated(team, turn + count):
            if first == 1:
                _start(process, task, loop, failed)
            if process.name not in failed:
                rows += _block(process, judge, task, loop, steps, failed)
    errors = [{"solver": solver, "error": error} for solver, error in failed.items()]
    return [{"loop": name, "task": task.name, **row} for row in rows + errors]


def _start(process: Process, task: Task, loop: Loop, failed: dict[str, str]) -> None:
    try:
        process.cold(task.name, loop.states[0], 1)
    except PeerError as error:
        failed[process.name] = str(error)


def _block(
    process: Process, judge: Judge, task: Task, loop: Loop, steps: range, failed: dict[str, str]
) -> list[dict[str, Any]]:
    try:
        results = process.replan(task.name, [loop.states[step] for step in steps])
    except PeerError as error:
        failed[process.name] = str(error)
        return []
    rows = []
    for step, (timing, answer) in zip(steps, results, strict=True):
        verdict = judge.verdict(loop.states[step], answer)
        rows.append(
            {
                "solver": process.name, "step": step, "seconds": timing.seconds, "interrupted": timing.interrupted,
                "gap": verdict.gap(loop.optima[step]),
                "violation": verdict.violation, "defect": verdict.defect,
                "rolled_violation": verdict.rolled_violation, "iterations": answer.iterations,
                "claim": answer.claim, "usable": answer.usable, "callbacks": answer.callbacks,
            }
        )  # fmt: skip
    return rows
