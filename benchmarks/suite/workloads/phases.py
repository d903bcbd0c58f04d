"""Where the time of doorman's own iteration goes: every kernel by itself, again and again at the same point."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import doorman
from doorman.numba_types.handles import held
from doorman.ocp.solvers.iterations import guess, nominal, rollout
from doorman.ocp.solvers.iterations.real_time import follow
from doorman.ocp.solvers.sweeps import sweep
from doorman.ocp.solvers.sweeps.active_set import classify
from suite.session import Session
from suite.task import Array
from suite.tasks import paper
from suite.workloads.cold import LOOP_STEPS

CALLS = 200
"""Of each kernel at each state; the median counts."""

STATES = 16
"""Of the loop."""


def measure(session: Session) -> dict[str, Any]:
    """Median seconds of every part of a replan, and of the whole call, on the solvers' core."""
    task = paper()
    available = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {session.core})
    try:
        planner = doorman.Planner(doorman.Scenario.load("paper", task.overrides))
        samples = [_at(planner, state) for state in session.loop(task, LOOP_STEPS).states[:: LOOP_STEPS // STATES]]
    finally:
        os.sched_setaffinity(0, available)
    return {"seconds": {name: float(np.median([sample[name] for sample in samples])) for name in samples[0]}}


def _at(planner: doorman.Planner, state: Array) -> dict[str, float]:
    """At one state, after a cold plan and a replan from there."""
    planner.plan(state)
    planner.replan(state, elapsed=0.0)
    seconds = {name: _median(call) for name, call in _parts(planner.solver, state.copy()).items()}
    seconds["whole call"] = _median(lambda: planner.replan(state, elapsed=0.0))
    seconds["Python"] = seconds["whole call"] - seconds["all kernels in one call"]
    return seconds


def _parts(solver: Any, state: Array) -> dict[str, Callable[[], Any]]:
    """Kernels of one real-time iteration, each as a call of its own, which stays with the trajectory; the last is all of them."""
    model, work, content, penalty = solver._model, solver._memory, solver._work, solver.options.penalty
    trajectory = held(content.nominal)
    return {
        "shift": lambda: guess.shift_guess(model, work, state, 0.0, 1),
        "linearise": lambda: nominal.linearize(model, work),
        "active set": lambda: classify(work, trajectory, penalty),
        "backward": lambda: sweep.sweep(model, work, penalty, 0.0, solver.problem.horizon - 1),
        "forward": lambda: sweep.step_along(work),
        "rollout": lambda: rollout.roll_out(model, work, -1, 0.0, 0),
        "all kernels in one call": lambda: follow(model, work, state, 0.0, 1, 1, 0, 1, np.inf, np.inf),
    }


def _median(call: Callable[[], Any]) -> float:
    call()
    seconds = []
    for _ in range(CALLS):
        started = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - started)
    return float(np.median(seconds))
