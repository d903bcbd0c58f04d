"""The planner of a tip that can only push, all its constraints on: beside the paper's, and beside acados at the same states."""

from __future__ import annotations

import gc
import os
import resource
import time
from typing import Any, cast

import numpy as np

import doorman
from suite.process import PeerError, Process
from suite.session import Session
from suite.standard.judge import Judge, Verdict
from suite.standard.push import push_case, push_planner, push_task
from suite.standard.task import Case
from suite.states import DOOR_RATE_NOISE, NOISE
from suite.task import Array
from suite.tasks import paper
from suite.workloads.cold import rotated

STEPS, QUICK_STEPS = 150, 50
"""Of a flight."""

BUDGET = 8e-3
"""Of a replan [s]."""

FLIGHTS, QUICK_FLIGHTS = 6, 2
"""Without and with noise, each; the planners take turns."""

SOLVERS = ("whole_body", "acados", "acados_slack")
"""Those that meet at the same states."""

SHARES = {"none": 0.0, "3 mm, 0.2°": 0.3, "1 cm, 0.6°": 1.0}
"""Of the noise, on every state."""

COLD_EVERY = 10
"""Steps between the states of a loop without noise that are planned from anew."""


def measure(session: Session) -> dict[str, Any]:
    """Replans along closed loops of either planner's own plans, and along the push's by everybody, without and with noise."""
    available = os.sched_getaffinity(0)
    planners = {
        "push": push_planner(),
        "paper": doorman.Planner(doorman.Scenario.load("paper")),
        "paper, six inequalities": doorman.Planner(doorman.Scenario.load("paper", paper().overrides)),
    }
    steps, flights = (QUICK_STEPS, QUICK_FLIGHTS) if session.quick else (STEPS, FLIGHTS)
    rows: list[dict[str, Any]] = []
    os.sched_setaffinity(0, {session.core})
    gc.disable()  # as `doorman open` does in flight
    try:
        for flight in range(flights):
            for name, planner in planners.items():
                for noisy in (False, True):
                    rows += [{"planner": name, **row} for row in _fly(planner, steps, flight, float(noisy))[0]]
    finally:
        gc.enable()
        os.sched_setaffinity(0, available)
    counts = {name: _rows(planner) for name, planner in planners.items()}
    return {"rows": rows, "rows_of_a_node": counts, **_meet(session, planners["push"], steps, flights)}


def _meet(session: Session, planner: doorman.Planner, steps: int, flights: int) -> dict[str, Any]:
    """Everybody at the states of the planner's own loops: one iteration from the shifted own plan, and cold plans."""
    task = push_task(planner)
    team, judge = session.team(cast(Any, task), SOLVERS), Judge(task)
    loops = {
        noise: [push_case(planner, state) for state in _fly(planner, steps, 1, share)[1]]
        for noise, share in SHARES.items()
    }
    cold, replans = [], []
    for turn, case in enumerate(loops["none"][::COLD_EVERY]):
        for process in rotated(team, turn):
            cold.append({"solver": process.name, "state": turn, **_cold(process, judge, case)})
    for turn in range(flights):
        for noise, cases in loops.items():
            for process in rotated(team, turn):
                replans += [{"solver": process.name, "noise": noise, **row} for row in _follow(process, judge, cases)]
    session.release(cast(Any, task))
    return {"cold": cold, "replans": replans}


def _cold(process: Process, judge: Judge, case: Case) -> dict[str, Any]:
    try:
        timings, answer = process.cold(judge.task.name, cast(Any, case), 3)
    except PeerError as error:
        return {"holds": False, "error": str(error)}
    verdict = judge.verdict(case, answer.states, answer.inputs)
    seconds = min(timing.on_core for timing in timings)
    return {"seconds": seconds, "holds": verdict.holds, "iterations": answer.iterations, **_found(verdict)}


def _follow(process: Process, judge: Judge, cases: list[Case]) -> list[dict[str, Any]]:
    """A cold plan at the first state, a replan at each of the others."""
    try:
        process.cold(judge.task.name, cast(Any, cases[0]), 1)
        results = process.replan(judge.task.name, cast(Any, cases[1:]))
    except PeerError as error:
        return [{"error": str(error)}]
    return [
        {
            "seconds": timing.seconds, "interrupted": timing.interrupted, "usable": answer.usable,
            **_found(judge.verdict(case, answer.states, answer.inputs)),
        }
        for case, (timing, answer) in zip(cases[1:], results, strict=True)
    ]  # fmt: skip


def _found(verdict: Verdict) -> dict[str, Any]:
    """What an answer is worth."""
    return {"cost": verdict.cost, "violation": verdict.violation, "defect": verdict.defect}


def _rows(planner: doorman.Planner) -> int:
    """Constraints and bounds at a node."""
    problem = planner.planning.problem()
    ends = np.concatenate([np.asarray(end) for end in vars(problem.bounds).values()])
    return problem.n_constraints + problem.n_input_constraints + int(np.isfinite(ends).sum())


def _fly(planner: doorman.Planner, steps: int, seed: int, share: float) -> tuple[list[dict[str, Any]], list[Array]]:
    """A closed loop of a planner's own plans with a share of the noise: its replans, and its states."""
    rng, rows = np.random.default_rng(seed), []
    plan = planner.plan(_start(planner))
    states = [_start(planner)]
    for step in range(1, steps + 1):
        states.append(plan.states[1] + (share * _noise(planner, rng) if share else 0.0))
        interruptions = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
        started = time.perf_counter()
        plan = planner.replan(states[-1], time_limit=BUDGET)
        seconds = time.perf_counter() - started
        rows.append(
            {
                "noisy": share > 0.0, "step": step, "seconds": seconds, "iterations": plan.iterations,
                "flyable": plan.flyable, "violation": plan.max_violation, "claim": plan.status.value,
                "interrupted": resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw > interruptions,
            }
        )  # fmt: skip
    return rows, states


def _start(planner: doorman.Planner) -> Array:
    """At rest; a tip that can only push rests on the leaf."""
    return np.array(planner.planning.start_state)


def _noise(planner: doorman.Planner, rng: np.random.Generator) -> Array:
    names = planner.planning.state_names
    spread = np.full(len(names), NOISE)
    spread[names.index("door rate")] = DOOR_RATE_NOISE
    return np.asarray(spread * rng.standard_normal(len(names)))
