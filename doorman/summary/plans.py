"""Figures of a run's plans and of its speed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.recording import Recording
from doorman.recording.recording import Topic


def cold_plans(plan: Topic) -> NDArray[np.bool_]:
    """Which plans began without one before, shape (m,); of a recording that does not say so, the first of several."""
    cold = np.zeros(len(plan.time), bool)
    if "cold" in plan:
        cold[:] = plan["cold"]
    else:
        cold[:1] = len(cold) > 1
    return cold


def planner_figures(recording: Recording) -> dict[str, Any]:
    """Times, rate and missed deadlines of a run's plans, and the least force that they planned."""
    if "plan" not in recording:
        nothing = {"median": None, "p99": None, "max": None, "cold": None}
        return {"planner_ms": nothing, "planner_rate_hz": 0.0, "deadline_misses": 0, "planned_normal_force_n_min": None}
    plan = recording["plan"]
    cold, milliseconds = cold_plans(plan), 1e3 * plan["solve_time"]
    warm = milliseconds[~cold]
    span = float(plan.time[-1] - plan.time[0])
    return {
        "planner_ms": {
            "median": float(np.median(warm)) if len(warm) else None,
            "p99": float(np.percentile(warm, 99)) if len(warm) else None,
            "max": float(warm.max()) if len(warm) else None,
            "cold": float(milliseconds[cold].max()) if cold.any() else None,
        },
        "planner_rate_hz": (len(plan.time) - 1) / span if span > 0.0 else 0.0,
        "deadline_misses": int(plan["deadline_missed"].sum()),
        "planned_normal_force_n_min": float(plan["least_normal_force"].min()),
    }


def realtime_factor(recording: Recording) -> float | None:
    """How much faster than real time the flight was; None if that was not measured."""
    end = recording["mission"]
    wall_time = float(end["wall_time"][-1])
    return float(end.time[-1]) / wall_time if wall_time > 0.0 else None
