"""Summary of a run: the figures of `summary.json`, from the true states where a simulator recorded them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.collision.scene import CollisionScene
from doorman.exceptions import RecordingError
from doorman.flown_constraints import flown_constraints
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recording
from doorman.recording.recording import Topic
from doorman.simulation.reality.causes import true_causes

Array = NDArray[np.float64]

OPEN_TOLERANCE = math.radians(2.0)
"""|α − target| below this counts as opened [rad]."""

_KEPT_CONTACT = 0.9
"""A smaller share of time in contact is worth a word in the verdict."""

FLOWN = "flown to its end"
"""How the last message of a mission begins that went all its way; what it has seen of the door may follow."""
COMPLETED, GOAL_MISSED, GIVEN_UP = "completed", "goal missed", "given up"
"""Outcomes of a mission that went all its way and has opened the door in truth, of one that went all its way and has not, and of
one that retreated to the hover instead."""

_STANDS_FOR = 1.0
_STANDS = math.radians(0.5)
"""A door that is faster on average [rad/s] in so long a time [s] before the flight's end does not stay where it is."""

_CLEARANCE_INTERVAL = 0.01
"""Between states at which FCL measures the clearance [s]."""


def summarize(recording: Recording, model: Model) -> dict[str, Any]:
    """Figures of a simulated run.

    Args:
        recording: With the topics `truth`, `estimate` and `mission`, and `plan` if the mission came so far.
        model: Model of the scenario that was flown.

    Returns:
        The keys of `summary.json`; a figure that the run does not define, such as the time to open of a door that stayed
        shut, is None.

    Raises:
        RecordingError: if the recording has no true states.
    """
    if "truth" not in recording:
        raise RecordingError(
            "no true states to judge the run by", field="topic", given="truth", allowed="a simulated run"
        )
    truth = recording["truth"]
    time, angle = truth.time, truth["door_angle"]
    target = float(model.goal_state[3])
    touched = np.flatnonzero(truth["touching"])
    touched_at = float(time[touched[0]]) if len(touched) else float(time[0])
    moving = _rate_at_the_end(recording)
    opened_at = time_to_open(time, angle, target) if abs(moving) < _STANDS else None
    outcome, reason = _outcome(recording)
    states = recording["mission"]["state"].tolist()
    if outcome == COMPLETED and opened_at is None:
        outcome, reason = GOAL_MISSED, _missed(model.true_door, float(angle[-1]), target, moving, reason)
    return {
        "outcome": outcome,
        "reason": reason,
        "attempts": 1 + states[1:].count("hover"),
        "opened": opened_at is not None,
        "went_through": outcome == COMPLETED and "through" in states,
        "final_door_angle_deg": math.degrees(float(angle[-1])),
        "target_door_angle_deg": math.degrees(target),
        **_where_it_ended(model.true_door, float(angle[-1]), target),
        "time_to_open_s": None if opened_at is None else max(opened_at - touched_at, 0.0),
        "hover_to_goal_s": opened_at,
        "duration_s": float(time[-1]),
        "max_constraint_violation_m": _largest_violation(recording, model),
        "min_clearance_m": _min_clearance(recording, model),
        "collisions": int(truth["collisions"].sum()),
        "contact_fraction": _contact_fraction(recording, 0.0),
        "contact_fraction_after_1s": _contact_fraction(recording, 1.0),
        "max_pull_force_n": float(truth["max_pull"].max()),
        "max_push_force_n": _largest_push(recording),
        "door_angle_estimate_error_deg_max": _estimate_error(recording),
        "estimates": _estimates(recording, model),
        "true_causes": true_causes(recording, model),
        **_planner_figures(recording),
        "realtime_factor": _realtime_factor(recording),
    }


def verdict(summary: dict[str, Any]) -> tuple[bool, str]:
    """Whether the door was opened and nothing touched, and a sentence that says what happened.

    Args:
        summary: As `summarize` returns it.

    Returns:
        The verdict and the sentence.
    """
    final, target = summary["final_door_angle_deg"], summary["target_door_angle_deg"]
    where = f"the door ended at {final:.1f}°, {abs(final - target):.1f}° from the target of {target:.1f}°"
    if summary["unit"] == "m":
        final, target = summary["final_opening"], summary["target_opening"]
        where = f"it ended {final:.3f} m open, {1e3 * abs(final - target):.0f} mm from the target of {target:.3f} m"
    if summary["collisions"]:
        return False, f"Something was touched ({summary['collisions']} contacts other than tip and leaf); {where}."
    if summary["min_clearance_m"] <= 0.0:
        return False, f"Shapes overlap by {-summary['min_clearance_m'] * 1e3:.1f} mm; {where}."
    if summary["outcome"] == GIVEN_UP:
        return False, f"The mission was given up: {summary['reason']}; {where}."
    if not summary["opened"]:
        lost = summary["contact_fraction"] < _KEPT_CONTACT
        why = f"the tip was on the leaf for only {summary['contact_fraction']:.0%} of the time and " if lost else ""
        more = f" ({summary['reason']})" if summary["outcome"] == GOAL_MISSED else ""
        return False, f"The door was not opened: {why}{where}{more}."
    passed = ", the vehicle is behind it" if summary["went_through"] else ""
    return True, f"The door was opened in {summary['time_to_open_s']:.2f} s{passed} and nothing was touched; {where}."


def _where_it_ended(door: Door, angle: float, target: float) -> dict[str, Any]:
    """Opening and error in the unit of the joint: of a hinge the error of its angle, of a slide that of its opening."""
    opening, wanted = door.opening_of(angle), door.opening_of(target)
    if door.slides:
        return {"final_error": opening - wanted, "unit": "m", "final_opening": opening, "target_opening": wanted}
    opening, wanted = math.degrees(opening), math.degrees(wanted)
    return {
        "final_error": math.degrees(angle - target), "unit": "deg", "final_opening": opening, "target_opening": wanted,
    }  # fmt: skip


def time_to_open(time: Array, angle: Array, target: float) -> float | None:
    """First time after which |α − target| stays below 2°.

    Args:
        time: Shape (m,) [s].
        angle: α, shape (m,) [rad].
        target: [rad].

    Returns:
        The time [s], or None if the last angle is farther off.
    """
    off = np.flatnonzero(np.abs(angle - target) >= OPEN_TOLERANCE)
    if len(off) == 0:
        return float(time[0])
    return float(time[off[-1] + 1]) if off[-1] + 1 < len(time) else None


def cold_plans(plan: Topic) -> NDArray[np.bool_]:
    """Which plans began without one before, shape (m,); of a recording that does not say so, the first of several.

    Args:
        plan: The topic `plan`.
    """
    cold = np.zeros(len(plan.time), bool)
    if "cold" in plan:
        cold[:] = plan["cold"]
    else:
        cold[:1] = len(cold) > 1
    return cold


def _rate_at_the_end(recording: Recording) -> float:
    """Of the door, on average over the last second [rad/s]."""
    truth = recording["truth"]
    return float(truth["door_rate"][truth.time >= truth.time[-1] - _STANDS_FOR].mean())


def _missed(door: Door, angle: float, target: float, moving: float, said: str) -> str:
    """Why a mission that went all its way has not opened the door."""
    if abs(angle - target) >= OPEN_TOLERANCE:
        why = f"the door ended at {door.in_words(angle)}"
    else:
        speed = f"{door.per_angle * moving:+.3f} m/s" if door.slides else f"{math.degrees(moving):+.1f}°/s"
        why = f"the door still moved at the end, at {speed}"
    return f"{why}; the mission said: {said}" if said else why


def _largest_violation(recording: Recording, model: Model) -> float:
    """Of the planner's constraints, which keep the vehicle before the wall: until it flies through the doorway."""
    truth, mission = recording["truth"], recording["mission"]
    through = mission.time[mission["state"] == "through"]
    flown = slice(int(np.searchsorted(truth.time, through[0])) if len(through) else None)
    rows = flown_constraints(
        model, *(truth[field][flown] for field in ("position", "attitude", "door_angle", "arm_angles"))
    )
    return float(max(rows.max(), 0.0))


def _largest_push(recording: Recording) -> float | None:
    """In any physics step; at any tick in recordings that do not have that; None if they have neither [N]."""
    truth = recording["truth"]
    for field in ("max_push", "tip_normal_force"):
        if field in truth:
            return max(float(truth[field].max()), 0.0)
    return None


def _at_the_door(recording: Recording, after: float = 0.0) -> NDArray[np.bool_]:
    """Ticks of every attempt from a time after its first contact until the tip lets go, or the end, shape (m,)."""
    truth, mission = recording["truth"], recording["mission"]
    chosen = np.zeros(len(truth.time), bool)
    came, let_go = 0, False
    for time, state in [*zip(mission.time, mission["state"], strict=True), (math.inf, "retreat")]:
        tick = int(np.searchsorted(truth.time, time))
        if state in ("release", "retreat") and not let_go:
            let_go, touched = True, np.flatnonzero(truth["touching"][came:tick])
            if len(touched):
                first = truth.time[came + touched[0]] + after
                chosen[int(np.searchsorted(truth.time, first - 1e-9)) : tick] = True
        elif state in ("hover", "touch"):
            came, let_go = tick, False
    return chosen


def _min_clearance(recording: Recording, model: Model) -> float:
    truth = recording["truth"]
    ticks = max(round(_CLEARANCE_INTERVAL / max(float(np.diff(truth.time[:2]).sum()), 1e-9)), 1)
    chosen = slice(None, None, ticks)
    rotations = np.array([rotation_body_to_world(attitude) for attitude in truth["attitude"][chosen]])
    scene = CollisionScene(model.vehicle, model.true_door)
    clearances = scene.min_clearance_along(
        truth["position"][chosen], rotations, truth["arm_angles"][chosen], truth["door_angle"][chosen]
    )
    return float(clearances.worst.distance)


def _contact_fraction(recording: Recording, after: float) -> float:
    """Share of time in contact from a time after the first touch until the tip lets go, or the end, over all attempts."""
    touching = recording["truth"]["touching"]
    if not _at_the_door(recording).any():
        return 0.0
    chosen = _at_the_door(recording, after)
    return float(np.mean(touching[chosen])) if chosen.any() else 1.0


def _outcome(recording: Recording) -> tuple[str, str]:
    """How the mission ended by its own account, and why, or what it has seen of the door."""
    mission = recording["mission"]
    states, words = [str(state) for state in mission["state"]], str(mission["message"][-1])
    if words == "interrupted" or words.startswith("failed: "):
        return words.split(":")[0], words
    if "done" not in states:
        return "cut off", f"the flight ended in the phase {states[-2] if len(states) > 1 else states[-1]}"
    if words.startswith(FLOWN):
        return COMPLETED, words.removeprefix(FLOWN).lstrip(", ")
    return GIVEN_UP, words


def _estimates(recording: Recording, model: Model) -> dict[str, dict[str, float]]:
    """Parameters of the hinge as estimated at the end, with their standard deviations, and the true ones."""
    estimate, simulation, door = recording["estimate"], model.scenario.simulation, model.true_door
    arm = door.per_angle
    mass = 1.0 if simulation.door_mass is None else simulation.door_mass / door.mass
    rest = door.rest_angle if simulation.door_rest_angle is None else simulation.door_rest_angle
    true = {
        "damping": door.damping if simulation.door_damping is None else arm**2 * simulation.door_damping,
        "friction": door.friction if simulation.door_friction is None else arm * simulation.door_friction,
        "stiffness": door.stiffness if simulation.door_stiffness is None else arm**2 * simulation.door_stiffness,
        "inertia": door.inertia * mass,
    }
    found = {
        name: {"value": float(estimate["hinge"][-1, i]), "deviation": float(estimate["hinge_deviation"][-1, i]),
               "true": float(value)}
        for i, (name, value) in enumerate(true.items())
    }  # fmt: skip
    angle = float(recording["truth"]["door_angle"][-1])
    turned = float(model.start_state[3]) - angle
    found["torque"] = {
        "value": found["friction"]["value"] + found["stiffness"]["value"] * turned,
        "deviation": float(estimate["torque_deviation"][-1]),
        "true": true["friction"] + true["stiffness"] * (rest - angle),
    }
    found = {
        name: _in_joint(figures, 1 if name in ("friction", "torque") else 2, arm) for name, figures in found.items()
    }
    return found | (_place(recording, model) if door.vertical and "door_place" in estimate else {})


def _place(recording: Recording, model: Model) -> dict[str, dict[str, float]]:
    """Where the door stands against the map, as estimated at the end, and in truth."""
    estimate, simulation = recording["estimate"], model.scenario.simulation
    true = (*simulation.door_offset[:2], simulation.door_yaw)
    return {
        name: {"value": float(estimate["door_place"][-1, i]), "deviation": float(estimate["door_place_deviation"][-1, i]),
               "true": float(true[i])}
        for i, name in enumerate(("door_x", "door_y", "door_yaw"))
    }  # fmt: skip


def _in_joint(figures: dict[str, float], power: int, per_angle: float) -> dict[str, float]:
    """Figures of the URDF's joint: newtons and kilograms of a slide."""
    return figures if per_angle == 1.0 else {name: value / per_angle**power for name, value in figures.items()}


def _estimate_error(recording: Recording) -> float:
    truth, estimate = recording["truth"], recording["estimate"]
    count = min(len(truth.time), len(estimate.time))
    error = estimate["state"][:count, 3] - truth["door_angle"][:count]
    return math.degrees(float(np.abs((error + math.pi) % (2 * math.pi) - math.pi).max()))


def _planner_figures(recording: Recording) -> dict[str, Any]:
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


def _realtime_factor(recording: Recording) -> float | None:
    end = recording["mission"]
    wall_time = float(end["wall_time"][-1])
    return float(end.time[-1]) / wall_time if wall_time > 0.0 else None
