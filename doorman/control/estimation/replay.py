"""A recorded flight through the estimator, tick by tick as it was flown: what was measured, and the commands as they were sent.

What is known when a pose comes follows from the time at which it was true by the leaf's own rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimator, Tie
from doorman.estimation.leaf.hypotheses import PUSHING, STANDING, TOUCHING
from doorman.estimation.leaf.leaf_filter import SLIPS, WINDS
from doorman.estimation.leaf.numbers import TUNED, part
from doorman.exceptions import DoormanError, RecordingError
from doorman.model import Model
from doorman.recording import Recording
from doorman.signals import LeafReading, Measurement

_AT_THE_LEAF = ("touch", "open", "hold", "recover", "take_back", "release", "retreat")
"""Phases of a mission in which the tip may touch."""
_AT_THE_FRAME = "touch_frame"
"""Phase in which it may touch the frame."""
_MEASURED = ("position", "velocity", "attitude", "body_rates", "arm_angles", "arm_rates")
_FEWEST = 50
"""Poses at least."""
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
    """Run the estimator on a recording; `changes` are other values of `leaf_numbers`, by name: those of `TUNED`."""
    _check(recording, changes or {})
    measured, estimator = recording["measurement"], Estimator(model, changes)
    columns = [np.asarray(measured[name], dtype=np.float64) for name in (*_MEASURED, "pose_time")]
    whole = np.flatnonzero(np.isfinite(np.column_stack(columns)).all(axis=1))
    if (poses := len(np.unique(columns[-1][whole]))) < _FEWEST:
        raise RecordingError("too few poses", field="measurement", given=poses, allowed=f"at least {_FEWEST}")
    times = measured.time[whole]
    commands, ties, faces = _commands(recording, model, times), _ties(recording, times), _faces(recording, model, whole)
    felt = recording["tip_sensor"] if "tip_sensor" in recording else None
    forces = {} if felt is None else dict(zip(felt.time.tolist(), felt["force"].tolist(), strict=True))
    readings = _readings(recording, times)
    rows: list[tuple[Any, ...]] = []
    last, run = float(times[0]), estimator.run
    for k, now in enumerate(times.tolist()):
        parts: dict[str, Any] = {
            name: column[whole[k]].copy() for name, column in zip(_MEASURED, columns, strict=False)
        }
        posed = float(columns[-1][whole[k]])
        is_new = run is not None and run.time != posed
        estimator.note_force(commands[k])
        estimator.feel(faces[k])
        seen = Measurement(now, **parts, pose_time=posed, tip_force=forces.get(now), leaf=readings[k])
        estimator.update(seen, *ties[k], now - last)
        last, run = now, estimator.run
        assert run is not None
        if is_new:
            found = run.estimate
            rows.append((
                now, posed, found.mean, found.deviations, found.chances, found.outputs["normal_force"],
                [found.outputs[name] for name in WINDS], [found.outputs[name] for name in SLIPS], run.status,
            ))  # fmt: skip
    assert run is not None
    came, true, mean, deviations, chances, force, wind, slip, statuses = (
        np.array(each) for each in zip(*rows, strict=True)
    )
    names = run.estimate.hypotheses
    touching = chances[:, [name in TOUCHING for name in names]].sum(axis=1)
    rubbing = chances[:, [name in (PUSHING, STANDING) for name in names]].sum(axis=1)
    slips = (rubbing > 0.5) & (((slip[:, :, 0] / slip[:, :, 1]) ** 2).sum(axis=1) > _SLIPS**2)
    joint = part(mean, "joint") + part(mean, "joint_rate") * (came - true)
    return LeafReplay(
        came, true, mean, deviations, joint, touching, chances, names,
        force, wind, slip, slips, statuses, run.log_likelihood, run.refused, run.mean_nis,
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


def _commands(recording: Recording, model: Model, times: Array) -> list[Array]:
    """Force of the rotors that was commanded since the tick before, shape (3,), body frame [N]."""
    command = recording["command"]
    sent = np.column_stack([command["side_force"], command["thrust"]])
    finite = np.isfinite(sent).all(axis=1)
    last = np.searchsorted(command.time[finite], times - 1e-9) - 1
    weight = np.array([0.0, 0.0, model.vehicle.weight])
    return [sent[finite][k] if k >= 0 else weight for k in last.tolist()]


def _readings(recording: Recording, times: Array) -> list[LeafReading | None]:
    """Newest reading of the leaf at each time, where one was believed."""
    if "door_sensor" not in recording:
        return [None] * len(times)
    sensed = recording["door_sensor"]
    rows = np.column_stack([sensed["joint"], sensed["leaf_time"], sensed["deviation"]])
    good = sensed["believed"].astype(bool) & np.isfinite(rows).all(axis=1)
    made = [LeafReading(*row) for row in rows[good].tolist()]
    return [made[k] if k >= 0 else None for k in (np.searchsorted(sensed.time[good], times + 1e-9) - 1).tolist()]


def _ties(recording: Recording, times: Array) -> list[tuple[Tie, bool]]:
    """What the mission's phase says of tip and leaf at each time, and whether the gripper is closed."""
    mission, command = recording["mission"], recording["command"]
    flown = mission["state"] != "end"  # says why the run ended, and is no phase
    phases, began = mission["state"][flown], mission.time[flown]
    at = np.maximum(np.searchsorted(began, times - 1e-9) - 1, 0)  # a phase is known from the tick after it began
    held = command["grip"].astype(bool)[np.clip(np.searchsorted(command.time, times) - 1, 0, None)]
    found = []
    for i, closes in zip(at.tolist(), held.tolist(), strict=True):
        phase = phases[i]
        tie = Tie.FREE
        if phase in _AT_THE_LEAF:
            tie = Tie.LEAVING if phase == "retreat" else Tie.PUSHING
            tie = Tie.GRIPPED if closes and phase != "touch" else tie
        found.append((tie, closes))
    return found


def _faces(recording: Recording, model: Model, ticks: NDArray[np.int64]) -> list[Array | None]:
    """Into which face the tip feels its way at each tick, by unit normals, shape (3,).

    A tip that feels for the frame has no reference that moves. The face is that of the nearest place.
    """
    found: list[Array | None] = [None] * len(ticks)
    if not model.frame_places or "setpoint" not in recording:
        return found
    mission, setpoint, measured = recording["mission"], recording["setpoint"], recording["measurement"]
    times = measured.time[ticks]
    states = mission["state"][np.clip(np.searchsorted(mission.time, times, side="right") - 1, 0, None)]
    moves = setpoint["velocity"][np.clip(np.searchsorted(setpoint.time, times) - 1, 0, None)].any(axis=1)
    tips = measured["position"] + model.coupling.tips(measured["attitude"], measured["arm_angles"])
    for k in np.flatnonzero((states == _AT_THE_FRAME) & ~moves).tolist():
        place = min(model.frame_places, key=lambda each: float(np.linalg.norm(each.point - tips[ticks[k]])))
        found[k] = place.normal
    return found
