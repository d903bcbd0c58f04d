"""Cold solves and closed loops of the standard problems, solver by solver in turn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from suite.machine import describe
from suite.process import PeerError, Process
from suite.session import Session
from suite.standard.judge import Judge, Verdict
from suite.standard.shooting import ProgramSolver, Shooting
from suite.standard.task import NAMES, Array, Case, case_of, cases_of, example, task_of
from suite.task import Answer
from suite.workloads.cold import rotated

STARTS, QUICK_STARTS = 100, 10

FLIGHTS, QUICK_FLIGHTS = 10, 2
"""Closed loops of each solver, from the first starts."""

_REFERENCE = {
    "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 1000, "ipopt.tol": 1e-9, "ipopt.constr_viol_tol": 1e-9,
    "ipopt.acceptable_tol": 1e-9, "expand": True,
}  # fmt: skip

_FAR = 1e6
"""A state beyond ends a closed loop."""


@dataclass(frozen=True)
class Reference:
    """What IPOPT finds from the same guess; its trajectory holds or it has failed."""

    cost: float
    holds: bool


def measure(session: Session) -> dict[str, Any]:
    """All problems."""
    rows: list[dict[str, Any]] = []
    flights: list[dict[str, Any]] = []
    sizes: dict[str, dict[str, Any]] = {}
    for name in NAMES:
        task = task_of(name)
        sizes[name] = {"title": task.title, "nx": task.nx, "nu": task.nu, "horizon": task.horizon}
        team, judge, ipopt = (
            session.team(cast(Any, task)),
            Judge(task),
            ProgramSolver(Shooting(task), "ipopt", _REFERENCE),
        )
        rows += _solves(team, judge, ipopt, cases_of(name, QUICK_STARTS if session.quick else STARTS))
        for turn in range(QUICK_FLIGHTS if session.quick else FLIGHTS):
            for process in rotated(team, turn):
                flight = _fly(process, judge, ipopt, turn)
                flights.append({"problem": name, "solver": process.name, "flight": turn, **flight})
        session.release(cast(Any, task))
    flown = [row for row in flights if "unsupported" not in row]
    machine = describe(session.python, session.peers_python, session.core)
    return {
        "rows": rows, "flights": flown, "sizes": sizes, "when": machine["when"], "processor": machine["processor"]
    }  # fmt: skip


def _solves(team: list[Process], judge: Judge, ipopt: ProgramSolver, cases: list[Case]) -> list[dict[str, Any]]:
    """Every case by every solver."""
    rows = []
    for index, case in enumerate(cases):
        ipopt.guess(case)
        ipopt.run()
        best = judge.verdict(case, *ipopt.trajectory())
        reference = Reference(best.cost, best.holds and bool(ipopt.stats["success"]))
        for process in rotated(team, index):
            known = {"problem": judge.task.name, "start": index, "solver": process.name}
            rows.append({**known, **_solve(process, judge, case, reference)})
    return rows


def _solve(process: Process, judge: Judge, case: Case, reference: Reference) -> dict[str, Any]:
    try:
        timings, answer = process.cold(judge.task.name, cast(Any, case), 1)
    except PeerError as error:
        return {"holds": False, "error": str(error), "usable": False, "reference_holds": reference.holds}
    verdict = judge.verdict(case, answer.states, answer.inputs)
    return {
        "seconds": timings[0].on_core, "holds": verdict.holds, "gap": _gap(verdict, reference), "cost": verdict.cost,
        "reference": reference.cost, "reference_holds": reference.holds, "violation": verdict.violation,
        "defect": verdict.defect, "iterations": answer.iterations, "claim": answer.claim, "usable": answer.usable,
    }  # fmt: skip


def _gap(verdict: Verdict, reference: Reference) -> float:
    """Relative excess of the cost over IPOPT's; none where that has failed."""
    return verdict.cost / reference.cost - 1.0 if reference.holds else -1.0


def _fly(process: Process, judge: Judge, ipopt: ProgramSolver, turn: int) -> dict[str, Any]:
    """A closed loop: one cold solve, then a replan at every step of a disturbed plant."""
    task = judge.task
    this = example(task.name)
    random, noise = np.random.default_rng(turn), np.asarray(this.noise)
    state = this.starts(turn + 1)[turn]
    states, seconds, unusable = [state], [], 0
    try:
        inputs = _first_plan(process, judge, ipopt, case_of(this, state)).inputs
        for _ in range(this.steps):
            state = this.plant(state, inputs[0]) + noise * random.standard_normal(task.nx)
            if not np.abs(state).max() < _FAR:
                break
            states.append(state)
            timing, answer = process.replan(task.name, [cast(Any, case_of(this, state))])[0]
            seconds.append(timing.on_core if timing.interrupted else timing.seconds)
            unusable += not answer.usable
            inputs = _next_inputs(inputs, answer)
    except PeerError as error:
        return {"unsupported": str(error)} if "Unsupported" in str(error) else {"reached": False, "error": str(error)}
    reached = len(states) == this.steps + 1 and this.reached(np.array(states))
    return {"reached": bool(reached), "seconds": seconds, "unusable": unusable}


def _first_plan(process: Process, judge: Judge, ipopt: ProgramSolver, case: Case) -> Answer:
    """The solver's own plan; from IPOPT's, where its own does not hold."""
    answer = process.cold(judge.task.name, cast(Any, case), 1)[1]
    if judge.verdict(case, answer.states, answer.inputs).holds:
        return answer
    ipopt.guess(case)
    ipopt.run()
    states, inputs = ipopt.trajectory()
    return process.cold(judge.task.name, cast(Any, replace(case, states=states, inputs=inputs)), 1)[1]


def _next_inputs(before: Array, answer: Answer) -> Array:
    """Those of the new plan; where it may not be used, the rest of the one before."""
    if answer.usable and np.isfinite(answer.inputs).all():
        return answer.inputs
    return np.vstack([before[1:], before[-1:]])
