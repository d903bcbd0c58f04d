"""Figures of a run: the keys of `summary.json`."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import RecordingError
from doorman.kinematics.doors.door import Door
from doorman.model import Model
from doorman.recording import Recording
from doorman.recording.recording import Topic
from doorman.simulation.reality.causes import true_causes
from doorman.summary import safety
from doorman.summary.estimates import estimates, largest_angle_error
from doorman.summary.measured import has_measured_leaf, measured_figures
from doorman.summary.outcome import COMPLETED, TOUCHED, judged, rate_at_the_end


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


def summarize(recording: Recording, model: Model, touched_after: int = 0) -> dict[str, Any]:
    if "truth" not in recording and has_measured_leaf(recording):
        return measured_figures(recording, model)
    if "truth" not in recording:
        raise RecordingError(
            "no true states to judge the run by", field="topic", given="truth",
            allowed="a simulated run, or one with a sensor of the door",
        )  # fmt: skip
    truth = recording["truth"]
    time, angle = truth.time, truth["door_angle"]
    target = model.goal_angle
    touched = np.flatnonzero(truth["touching"])
    touched_at = float(time[touched[0]]) if len(touched) else float(time[0])
    moving = rate_at_the_end(recording)
    outcome, reason, opened_at = judged(recording, model.true_door, time, angle, moving, target, model.turn_scale)
    states = recording["mission"]["state"].tolist()
    touches = safety.collisions(recording) + touched_after
    if outcome == COMPLETED and touches:
        outcome, reason = TOUCHED, f"{touches} contacts other than tip and leaf"
    return {
        "judged_by": "the true leaf",
        "outcome": outcome,
        "reason": reason,
        "attempts": attempts(states),
        "opened": opened_at is not None,
        "went_through": outcome in (COMPLETED, TOUCHED) and "through" in states,
        "final_door_angle_deg": math.degrees(float(angle[-1])),
        "target_door_angle_deg": math.degrees(target),
        **where_it_ended(model.true_door, float(angle[-1]), target),
        "time_to_open_s": None if opened_at is None else max(opened_at - touched_at, 0.0),
        "hover_to_goal_s": opened_at,
        "duration_s": float(time[-1]),
        "max_constraint_violation_m": safety.largest_violation(recording, model),
        "min_clearance_m": safety.min_clearance(recording, model),
        "collisions": touches,
        "contact_fraction": safety.contact_fraction(recording, 0.0),
        "contact_fraction_after_1s": safety.contact_fraction(recording, 1.0),
        "max_pull_force_n": float(truth["max_pull"].max()),
        "max_push_force_n": safety.largest_push(recording),
        "free_door_rate_deg_s_max": safety.free_door_rate(recording),
        "door_angle_estimate_error_deg_max": largest_angle_error(recording),
        "estimates": estimates(recording, model),
        "true_causes": true_causes(recording, model),
        **planner_figures(recording),
        "realtime_factor": realtime_factor(recording),
    }


def attempts(states: list[str]) -> int:
    """Number of attempts: each begins in a hover, to which the vehicle also comes back from the touch of the frame."""
    return 1 + sum(now == "hover" and before != "touch_frame" for before, now in itertools.pairwise(states))


def where_it_ended(door: Door, angle: float, target: float) -> dict[str, Any]:
    """Opening and error in the unit of the joint: of a hinge the error of its angle, of a slide that of its opening."""
    opening, wanted = door.opening_of(angle), door.opening_of(target)
    if door.slides:
        return {"final_error": opening - wanted, "unit": "m", "final_opening": opening, "target_opening": wanted}
    opening, wanted = math.degrees(opening), math.degrees(wanted)
    return {
        "final_error": math.degrees(angle - target), "unit": "deg", "final_opening": opening, "target_opening": wanted,
    }  # fmt: skip
