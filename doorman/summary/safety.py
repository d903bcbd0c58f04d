"""How near a run came to anything, and how hard and how long the tip was on the leaf."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.collision.scene import CollisionScene
from doorman.collision.shapes import tip_and_frame
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recording
from doorman.summary.flown_constraints import flown_constraints


def largest_violation(recording: Recording, model: Model) -> float:
    """Largest violation of the planner's constraints, which hold until the vehicle flies through the doorway."""
    truth, mission = recording["truth"], recording["mission"]
    through = mission.time[mission["state"] == "through"]
    flown = slice(int(np.searchsorted(truth.time, through[0])) if len(through) else None)
    fields = ("position", "attitude", "door_angle", "arm_angles")
    rows = flown_constraints(model, *(truth[field][flown] for field in fields))
    return float(max(rows.max(), 0.0))


def collisions(recording: Recording) -> int:
    """Contacts other than tip and leaf, summed over the ticks; the tip may touch the frame where the mission has it do so."""
    truth, number = recording["truth"], recording["truth"]["collisions"]
    feels = _feels_the_frame(recording)
    return int(number[~(feels & (truth["only_tip_on_frame"] != 0))].sum() if feels.any() else number.sum())


def _feels_the_frame(recording: Recording) -> NDArray[np.bool_]:
    """Ticks in which the tip is to touch what stands beside the leaf, or goes away from it, shape (m,)."""
    truth, mission = recording["truth"], recording["mission"]
    phases = np.maximum(np.searchsorted(mission.time, truth.time, side="right") - 1, 0)
    feels = mission["state"] == "touch_frame"
    feels[1:] |= feels[:-1] & np.isin(mission["state"][1:], ("retreat", "hover"))
    return np.asarray(feels[phases])


def free_door_rate(recording: Recording) -> float | None:
    """Largest rate of a door that the vehicle has let go of, while the tip is off it [deg/s]."""
    truth, mission = recording["truth"], recording["mission"]
    phases = np.maximum(np.searchsorted(mission.time, truth.time, side="right") - 1, 0)
    free = np.isin(mission["state"], ("release", "retreat"))[phases] & (truth["touching"] == 0)
    return math.degrees(float(np.abs(truth["door_rate"][free]).max())) if free.any() else None


def largest_push(recording: Recording) -> float | None:
    """Largest push of the tip in any physics step, or at any tick in recordings that do not have that [N]."""
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


def min_clearance(recording: Recording, model: Model, interval: float = 0.01) -> float:
    """Least distance of vehicle and door at intervals, apart from tip and what it is to touch, by FCL [m]."""
    truth = recording["truth"]
    ticks = max(round(interval / max(float(np.diff(truth.time[:2]).sum()), 1e-9)), 1)
    feels, every = _feels_the_frame(recording), np.arange(len(truth.time)) % ticks == 0
    frame = tip_and_frame(model.vehicle, model.true_door) if feels.any() else []
    least = math.inf
    for chosen, ignored in ((every & ~feels, []), (every & feels, frame)):
        if chosen.any():
            clearance = CollisionScene(model.vehicle, model.true_door, ignored).least_clearance(
                truth["position"][chosen],
                np.array([rotation_body_to_world(each) for each in truth["attitude"][chosen]]),
                truth["arm_angles"][chosen],
                truth["door_angle"][chosen],
            )
            least = min(least, clearance.distance)
    return least


def contact_fraction(recording: Recording, after: float) -> float:
    """Share of time in contact from a time after the first touch until the tip lets go, or the end, over all attempts."""
    touching = recording["truth"]["touching"]
    if not _at_the_door(recording).any():
        return 0.0
    chosen = _at_the_door(recording, after)
    return float(np.mean(touching[chosen])) if chosen.any() else 1.0
