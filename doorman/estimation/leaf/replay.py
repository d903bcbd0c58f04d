"""A recorded flight through the filter at the leaf: its poses and commands, as they were measured and sent.

The filter runs at the poses' time, takes what acts then from `Acting`, as in flight, and fuses readings of the leaf at their own
time. What is known now follows from the last pose by the leaf's own rate.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.estimation.leaf.acting import Acting
from doorman.estimation.leaf.hypotheses import PUSHING, STANDING, TOUCHING
from doorman.estimation.leaf.leaf_filter import AT_THE_FRAME, AT_THE_LEAF, AWAY, CLOSING, HELD, SLIPS, WINDS
from doorman.estimation.leaf.leaf_sensor import recorded_readings
from doorman.estimation.leaf.numbers import JOINT, JOINT_RATE, TUNED, leaf_numbers
from doorman.estimation.leaf.running import LeafRun
from doorman.exceptions import DoormanError, RecordingError
from doorman.model import Model
from doorman.position_noise import PositionNoise
from doorman.recording import Recording
from doorman.signals import Measurement

_AT_THE_LEAF = ("touch", "open", "hold", "recover", "take_back", "release", "retreat")
"""Phases of a mission in which the tip may touch."""

_AT_THE_FRAME = "touch_frame"
"""Phase in which it may touch the frame."""

_MEASURED = ("position", "attitude", "body_rates", "arm_angles", "arm_rates")

_SLIPS = 5.0
"""Deviations by which a tip moves on the face before it is said to slip."""


@dataclass(frozen=True)
class LeafReplay:
    """Estimate at every pose; arrays have a row for each."""

    time: Array
    """When the pose came, shape (k,) [s]."""
    pose_time: Array
    """When it was true, shape (k,) [s]."""
    mean: Array
    """Means of the states, at the pose's time, shape (k, n)."""
    deviations: Array
    """Shape (k, n)."""
    joint: Array
    """q when the pose came, shape (k,) [rad or m]."""
    touching: Array
    """Probability that the tip touches, shape (k,)."""
    probabilities: Array
    """Probability of each hypothesis, shape (k, M)."""
    hypotheses: tuple[str, ...]
    normal_force: Array
    """λ and its deviation, shape (k, 2) [N]."""
    wind: Array
    """On the vehicle, by components, each with its deviation, shape (k, 3, 2) [N]."""
    slip: Array
    """Velocity of the tip on the face, along and up, each with its deviation, shape (k, 2, 2) [m/s]."""
    slips: Array
    """Whether a tip that is not gripped slips on the face, shape (k,)."""
    statuses: Array
    """`Status` of every step, shape (k,): `LOST` where the filter began anew."""
    log_likelihood: float
    refused: int
    """Poses beyond their gate under every hypothesis."""
    mean_nis: float
    """Mean normalised innovation squared of the poses."""


def replay_leaf(recording: Recording, model: Model, changes: dict[str, float] | None = None) -> LeafReplay:
    """Run the filter on a recording; `changes` are other values of `leaf_numbers`, by name: those of `TUNED`."""
    _check(recording, changes or {})
    measured, pose_time = recording["measurement"], recording["measurement"]["pose_time"]
    whole = np.isfinite(np.column_stack([measured[name] for name in _MEASURED])).all(axis=1) & np.isfinite(pose_time)
    new = np.flatnonzero(np.concatenate([[True], np.diff(pose_time) > 1e-9]) & (pose_time >= 0.0) & whole)
    noise = PositionNoise()
    for number, place in enumerate(measured["position"][new]):
        noise.note(number, place)
    if math.isnan(noise.deviation):
        raise RecordingError(
            "too few poses", field="measurement", given=len(new), allowed="as many as tell their noise"
        )
    numbers = leaf_numbers(model, noise.deviation).replaced(changes or {})
    situations = _situations(recording, measured.time[new])
    faces = _faces(recording, model, new)
    felt = _felt(recording, pose_time[new], situations) if "tip_sensor" in recording else None
    inputs = _inputs(recording, model, whole, new)
    run = LeafRun(model, numbers, pose_time[new[0]], measured["position"][new[0]], inputs[0])
    rows: list[tuple[Any, ...]] = []
    readings = deque(recorded_readings(recording).tolist())
    for k in range(1, len(new)):
        reading = None if felt is None else felt[k : k + 1]
        while readings and readings[0][0] <= measured.time[new[k]]:
            _, seen_at, angle, deviation = readings.popleft()
            run.see_leaf(seen_at, angle, deviation / model.door.per_angle)
        if (faces[k] != faces[k - 1]).any():
            run.feels(faces[k])
        situation = AT_THE_FRAME if faces[k].any() else situations[k]
        position, _ = run.unswapped(float(pose_time[new[k]]), measured["position"][new[k]])
        status = run.step(float(pose_time[new[k]]), position, inputs[k], situation, reading)
        found = run.estimate
        rows.append((
            found.mean, found.deviations, list(found.probabilities.values()), found.outputs["normal_force"],
            [found.outputs[name] for name in WINDS], [found.outputs[name] for name in SLIPS], status,
        ))  # fmt: skip
    mean, deviations, probabilities, force, wind, slip, statuses = (np.array(each) for each in zip(*rows, strict=True))
    names, came = tuple(run.estimate.probabilities), measured.time[new[1:]]
    touching = probabilities[:, [name in TOUCHING for name in names]].sum(axis=1)
    rubbing = probabilities[:, [name in (PUSHING, STANDING) for name in names]].sum(axis=1)
    slips = (rubbing > 0.5) & (((slip[:, :, 0] / slip[:, :, 1]) ** 2).sum(axis=1) > _SLIPS**2)
    return LeafReplay(
        came, pose_time[new[1:]], mean, deviations, mean[:, JOINT] + mean[:, JOINT_RATE] * (came - pose_time[new[1:]]),
        touching, probabilities, names, force, wind, slip, slips, statuses, run.log_likelihood, run.refused, run.mean_nis,
    )  # fmt: skip


def _check(recording: Recording, changes: dict[str, float]) -> None:
    """What the replay cannot take."""
    for name, value in changes.items():
        if name not in TUNED:
            raise DoormanError("no such number", field=name, allowed=", ".join(TUNED))
        if not (math.isfinite(value) and value > 0.0):
            raise DoormanError("not a deviation, rate or time", field=name, given=value, allowed="a number above 0")
    for topic in ("measurement", "command", "mission"):
        if topic not in recording:
            raise RecordingError(
                "the recording lacks what the filter replays", field="topic", given=f"no {topic}",
                allowed="a run of doorman open or doorman fly",
            )  # fmt: skip


def _inputs(recording: Recording, model: Model, whole: NDArray[np.bool_], new: NDArray[np.int64]) -> Array:
    """What acts at every new pose, shape (k, m), tick by tick as in flight."""
    measured, command = recording["measurement"], recording["command"]
    sent = np.column_stack([command["side_force"], command["thrust"]])
    sent_at, sent = command.time[np.isfinite(sent).all(axis=1)], sent[np.isfinite(sent).all(axis=1)]
    weight = np.array([0.0, 0.0, model.vehicle.weight])
    acting, inputs, is_new = Acting(model.n_arm, weight, model.start_yaw), [], set(new.tolist())
    last = np.searchsorted(sent_at, measured.time - 1e-9) - 1
    columns = [measured[name] for name in _MEASURED]
    for k in np.flatnonzero(whole).tolist():
        position, attitude, rates, arm, arm_rates = (np.array(column[k], dtype=np.float64) for column in columns)
        posed = float(measured["pose_time"][k])
        tick = Measurement(float(measured.time[k]), position, position, attitude, rates, arm, arm_rates, posed)
        acting.note(tick, sent[last[k]] if last[k] >= 0 else weight)
        if k in is_new:
            inputs.append(acting.at(posed, attitude))
    return np.array(inputs)


def _felt(recording: Recording, times: Array, situations: list[str]) -> Array:
    """What the sensor in the tip reads at every pose, less what it has read where nothing touches, shape (k,) [N]."""
    sensor = recording["tip_sensor"]
    read = np.interp(times, sensor.time, sensor["force"])
    away = np.array([situation == AWAY for situation in situations])
    before = np.concatenate([[0.0], np.cumsum(away * read)[:-1]])
    return np.asarray(read - before / np.maximum(np.concatenate([[0.0], np.cumsum(away)[:-1]]), 1.0))


def _faces(recording: Recording, model: Model, new: NDArray[np.int64]) -> Array:
    """Into which face the tip feels its way at every new pose, by unit normals, shape (k, 3); zeros where into none.

    A tip that feels for the frame has no reference that moves. The face is that of the nearest place.
    """
    measured, found = recording["measurement"], np.zeros((len(new), 3))
    if not model.frame_places or "setpoint" not in recording:
        return found
    mission, setpoint, came = recording["mission"], recording["setpoint"], measured.time[new]
    states = mission["state"][np.clip(np.searchsorted(mission.time, came, side="right") - 1, 0, None)]
    moves = setpoint["velocity"][np.clip(np.searchsorted(setpoint.time, came) - 1, 0, None)].any(axis=1)
    tips = measured["position"] + model.coupling.tips(measured["attitude"], measured["arm_angles"])
    for k in np.flatnonzero((states == _AT_THE_FRAME) & ~moves).tolist():
        place = min(model.frame_places, key=lambda each: float(np.linalg.norm(each.point - tips[new[k]])))
        found[k] = place.normal
    return found


def _situations(recording: Recording, times: Array) -> list[str]:
    """What the mission's phase leaves possible at each time."""
    mission = recording["mission"]
    flown = mission["state"] != "end"  # says why the run ended, and is no phase
    phases, began = mission["state"][flown], mission.time[flown]
    gripped = recording["command"]["grip"].astype(bool)
    at = np.searchsorted(began, times, side="right") - 1
    held = gripped[np.clip(np.searchsorted(recording["command"].time, times) - 1, 0, None)]
    near = [i >= 0 and phases[i] in _AT_THE_LEAF for i in at]
    return [
        AWAY if not near[k] else AT_THE_LEAF if not held[k] else CLOSING if phases[i] == "touch" else HELD
        for k, i in enumerate(at)
    ]
