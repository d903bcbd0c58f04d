"""Moments of a flight: everything that the scene shows at one time, from a recording or from messages as they come."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import RecordingError
from doorman.recording import Recording, Topic

FRAMES_PER_SECOND = 30
"""Moments that are shown per second of flight."""

LONGEST_PLAN_AGE = 0.15
"""A plan that is older is not followed any more, and not shown [s]."""


@dataclass(frozen=True)
class Moment:
    """One time of a flight."""

    time: float  # [s]
    position: Array  # P, shape (3,), world frame [m]
    attitude: Array  # Φ, shape (3,) [rad]
    door_angle: float  # α [rad]
    arm_angles: Array  # H, shape (n,) [rad]
    tip_force: Array | None  # force of the tip on the door, shape (3,), world frame [N]; None if unknown
    planned_states: Array | None
    """States of the plan that was made last, shape (N + 1, 5 + n); None if there is none, or none any more."""
    phase: str  # state of the mission; empty before the first
    reason: str  # why the mission is there

    @property
    def finite(self) -> bool:
        """Whether the pose can be drawn."""
        return bool(np.isfinite([*self.position, *self.attitude, self.door_angle, *self.arm_angles]).all())


def recorded_moments(recording: Recording) -> list[Moment]:
    """Moments of a recorded flight, evenly spaced; poses are interpolated."""
    # The pose is the simulator's truth if the recording has it, else what was measured and estimated. Times with a value that is
    # not finite are left out.
    time, rows = _poses(recording)
    frames = time[0] + np.arange(int((time[-1] - time[0]) * FRAMES_PER_SECOND + 1e-6) + 1) / FRAMES_PER_SECOND
    rows = np.column_stack([np.interp(frames, time, column) for column in rows.T])
    force, plan, mission = _force(recording), recording.get("plan"), recording.get("mission")
    moments = []
    for now, row in zip(frames, rows, strict=True):
        phase, reason = _latest_phase(mission, now)
        moments.append(
            Moment(
                float(now), row[:3], row[3:6], float(row[6]), row[7:],
                None if force is None else force[1][_latest(force[0], now)],
                _latest_plan(plan, now), phase, reason,
            )
        )  # fmt: skip
    return moments


class CurrentMoment:
    """The moment that the newest messages of a recorder make; `update` takes in every one of them."""

    def __init__(self) -> None:
        self._newest: dict[str, tuple[float, dict[str, Any]]] = {}

    def update(self, topic: str, time: float, fields: Mapping[str, Any]) -> Moment | None:
        if topic in ("truth", "measurement", "estimate", "plan", "mission"):
            self._newest[topic] = (time, dict(fields))
        told_by = "truth" if "truth" in self._newest else "estimate"
        if topic != told_by or self._newest.keys().isdisjoint({"truth", "measurement"}):
            return None
        moment = self._moment(time)
        return moment if moment.finite else None

    def _moment(self, now: float) -> Moment:
        estimate = self._newest.get("estimate", (now, {}))[1]
        truth = self._newest.get("truth", (now, None))[1]
        pose = truth if truth is not None else self._newest["measurement"][1]
        made, plan = self._newest.get("plan", (now, {}))
        mission = self._newest.get("mission", (now, {}))[1]
        force = (truth or estimate).get("tip_force")
        return Moment(
            now, np.array(pose["position"]), np.array(pose["attitude"]),
            float(estimate["state"][3] if truth is None else truth["door_angle"]), np.array(pose["arm_angles"]),
            None if force is None else np.array(force),
            np.array(plan["states"]) if plan and now - made <= LONGEST_PLAN_AGE else None,
            str(mission.get("state", "")), str(mission.get("message", "")),
        )  # fmt: skip


def _poses(recording: Recording) -> tuple[Array, Array]:
    source = "truth" if "truth" in recording else "measurement"
    if source not in recording or (source == "measurement" and "estimate" not in recording):
        raise RecordingError(
            "no motion to replay", field="recording", given=", ".join(recording) or "no topic",
            allowed="topic truth, or measurement and estimate",
        )  # fmt: skip
    topic = recording[source]
    angle = topic["door_angle"] if source == "truth" else _leaf(recording, topic.time)
    rows = np.column_stack([topic["position"], topic["attitude"], angle, topic["arm_angles"]])
    good = np.isfinite(rows).all(axis=1)
    if not good.any():
        raise RecordingError("no finite motion to replay", field=source)
    rows = rows[good]
    rows[:, 3:6] = np.unwrap(rows[:, 3:6], axis=0)
    return topic.time[good], rows


def _leaf(recording: Recording, times: Array, within: float = 0.3) -> Array:
    """α at times, as a sensor of the door has measured it where there are readings within some time, else as estimated."""
    angle: Array = np.interp(times, recording["estimate"].time, recording["estimate"]["state"][:, 3])
    if "door_sensor" not in recording:
        return angle
    sensor = recording["door_sensor"]
    read, believed = sensor["leaf_time"], sensor["believed"].astype(bool)
    if believed.sum() < 2:
        return angle
    read, seen = read[believed], sensor["door_angle"][believed]
    after = np.clip(np.searchsorted(read, times), 1, len(read) - 1)
    near = np.minimum(np.abs(times - read[after - 1]), np.abs(times - read[after])) < within
    return np.asarray(np.where(near, np.interp(times, read, seen), angle))


def _force(recording: Recording) -> tuple[Array, Array] | None:
    for source in ("truth", "estimate"):
        if source in recording and "tip_force" in recording[source]:
            return recording[source].time, recording[source]["tip_force"]
    return None


def _latest(times: Array, now: float) -> int:
    """Index of the last time that is not after now; the first one before that."""
    return max(int(np.searchsorted(times, now + 1e-9, side="right")) - 1, 0)


def _latest_plan(plan: Topic | None, now: float) -> Array | None:
    if plan is None:
        return None
    index = _latest(plan.time, now)
    states: Array = plan["states"][index]
    return states if 0.0 <= now + 1e-9 - plan.time[index] <= LONGEST_PLAN_AGE else None


def _latest_phase(mission: Topic | None, now: float) -> tuple[str, str]:
    if mission is None or now + 1e-9 < mission.time[0]:
        return "", ""
    index = _latest(mission.time, now)
    return str(mission["state"][index]), str(mission["message"][index])
