"""Figures of a flight by the measured leaf: a real flight has no other truth."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.model import Model
from doorman.recording import Recording
from doorman.summary.outcome import STANDS_FOR, judged

JUDGED_BY = "the measured leaf"
_FEWEST = 10
"""Readings that a flight is judged by."""


def measured_figures(recording: Recording, model: Model) -> dict[str, Any]:
    """Figures of a flight without true states, by a sensor of the door."""
    time, angle = _readings(recording)
    target = model.goal_angle
    late = time >= time[-1] - STANDS_FOR
    moving = float(np.polyfit(time[late], angle[late], 1)[0]) if late.sum() > 2 else 0.0
    outcome, reason, opened_at = judged(recording, model.door, time, angle, moving, target, model.turn_scale)
    gap = gaps(recording, model)
    touching = _touching(recording, gap)
    began = float(gap[0][touching][0]) if touching.any() else float(time[0])
    swing = (gap[0] >= began) & (gap[0] <= (opened_at or float(time[-1])))
    return {
        "judged_by": JUDGED_BY,
        "outcome": outcome,
        "reason": reason,
        "opened": opened_at is not None,
        "final_door_angle_deg": math.degrees(float(angle[-1])),
        "target_door_angle_deg": math.degrees(target),
        "time_to_open_s": None if opened_at is None else max(opened_at - began, 0.0),
        "hover_to_goal_s": opened_at,
        "contact_fraction": float(touching[swing].mean()) if swing.any() else 0.0,
        "readings": len(time),
        "believed": float(recording["door_sensor"]["believed"].mean()),
    }


def sentence_by_the_leaf(figures: dict[str, Any], unit: str = "°") -> str:
    """A sentence of what the sensor of the door says of a flight."""
    final, target = figures["final_door_angle_deg"], figures["target_door_angle_deg"]
    where = f"the door ended at {final:.1f}{unit}, {abs(final - target):.1f}{unit} from the target"
    if not figures["opened"]:
        return f"By the measured leaf the door was not opened: {where}."
    return f"By the measured leaf the door was opened in {figures['time_to_open_s']:.2f} s; {where}."


def has_measured_leaf(recording: Recording) -> bool:
    """Whether a flight can be judged so."""
    return "door_sensor" in recording and len(recording["door_sensor"].time) >= _FEWEST


def gaps(recording: Recording, model: Model) -> tuple[Array, Array]:
    """Distance of the tip before the measured leaf, at every reading."""
    measured, sensor, estimate = recording["measurement"], recording["door_sensor"], recording["estimate"]
    tips = measured["position"] + model.coupling.tips(measured["attitude"], measured["arm_angles"])
    offset, hinge = estimate["door_place"][-1], model.door.hinge_position
    cosine, sine = math.cos(offset[2]), math.sin(offset[2])
    back = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    from_hinge = (tips - hinge - [*offset[:2], 0.0]) @ back.T
    at = np.array([model.door.angle_of(one) for one in from_hinge])
    true = sensor["leaf_time"] >= measured.time[0]
    times = sensor["leaf_time"][true]
    tip = np.interp(times, measured["pose_time"], at)
    return times, model.coupling.lever_length * (tip - sensor["door_angle"][true])


def _readings(recording: Recording) -> tuple[Array, Array]:
    sensor = recording["door_sensor"]
    new = np.concatenate([[True], np.diff(sensor["leaf_time"]) > 0.0])
    return sensor["leaf_time"][new], sensor["door_angle"][new]


def _touching(recording: Recording, gap: tuple[Array, Array], beyond: float = 0.015) -> NDArray[np.bool_]:
    """Where the tip is as near to the leaf as it is where the mission opens the door, or little farther [m]."""
    states, times = recording["mission"]["state"], recording["mission"].time
    at = np.clip(np.searchsorted(times, gap[0], side="right") - 1, 0, None)
    opens = np.isin(states[at], ("open", "hold"))
    usual = float(np.median(gap[1][opens])) if opens.any() else 0.0
    return np.asarray(gap[1] < usual + beyond)
