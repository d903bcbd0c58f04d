"""The planner of a tip that can only push, all its constraints on, beside the paper's with six inequalities at a node."""

from __future__ import annotations

import gc
import os
import resource
import time
from typing import Any

import numpy as np

import doorman
from suite.session import Session
from suite.states import DOOR_RATE_NOISE, NOISE
from suite.task import Array
from suite.tasks import paper

STEPS, QUICK_STEPS = 150, 50
"""Of a flight."""

RESISTANCE = 0.8
"""Of the hinge that the push works against [N m]."""

BUDGET = 8e-3
"""Of a replan [s]."""

FLIGHTS, QUICK_FLIGHTS = 6, 2
"""Without and with noise, each; the planners take turns."""


def measure(session: Session) -> dict[str, Any]:
    """Replans along closed loops of either planner's own plans, without and with noise on the state."""
    available = os.sched_getaffinity(0)
    planners = {
        "push": doorman.Planner(doorman.Scenario.load("push")),
        "paper": doorman.Planner(doorman.Scenario.load("paper")),
        "paper, six inequalities": doorman.Planner(doorman.Scenario.load("paper", paper().overrides)),
    }
    planners["push"].update_door(friction=0.0, disturbance=-RESISTANCE)
    steps, flights = (QUICK_STEPS, QUICK_FLIGHTS) if session.quick else (STEPS, FLIGHTS)
    rows: list[dict[str, Any]] = []
    os.sched_setaffinity(0, {session.core})
    gc.disable()  # as `doorman open` does in flight
    try:
        for flight in range(flights):
            for name, planner in planners.items():
                for noisy in (False, True):
                    rows += [{"planner": name, **row} for row in _fly(planner, steps, flight, noisy)]
    finally:
        gc.enable()
        os.sched_setaffinity(0, available)
    return {"rows": rows, "rows_of_a_node": {name: _rows(planner) for name, planner in planners.items()}}


def _rows(planner: doorman.Planner) -> int:
    """Constraints and bounds at a node."""
    problem = planner.planning.problem()
    ends = np.concatenate([np.asarray(end) for end in vars(problem.bounds).values()])
    return problem.n_constraints + problem.n_input_constraints + int(np.isfinite(ends).sum())


def _fly(planner: doorman.Planner, steps: int, seed: int, noisy: bool) -> list[dict[str, Any]]:
    rng, rows = np.random.default_rng(seed), []
    plan = planner.plan(_start(planner))
    for step in range(1, steps + 1):
        state = plan.states[1] + (_noise(len(plan.states[1]), rng) if noisy else 0.0)
        interruptions = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
        started = time.perf_counter()
        plan = planner.replan(state, time_limit=BUDGET)
        seconds = time.perf_counter() - started
        rows.append(
            {
                "noisy": noisy, "step": step, "seconds": seconds, "iterations": plan.iterations,
                "flyable": plan.flyable, "violation": plan.max_violation, "claim": plan.status.value,
                "interrupted": resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw > interruptions,
            }
        )  # fmt: skip
    return rows


def _start(planner: doorman.Planner) -> Array:
    """At rest; a tip that can only push rests on the leaf."""
    return np.array(planner.planning.start_state)


def _noise(nx: int, rng: np.random.Generator) -> Array:
    spread = np.full(nx, NOISE)
    spread[4] = DOOR_RATE_NOISE
    return np.asarray(spread * rng.standard_normal(nx))
