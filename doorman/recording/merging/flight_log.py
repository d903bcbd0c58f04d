"""An autopilot's log, whichever autopilot wrote it: its rows as topics, without those that have an impossible time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.bounds import LONGEST
from doorman.exceptions import RecordingError

_GYRO = ("GyrX", "GyrY", "GyrZ")
_RATES = {
    "px4/vehicle_angular_velocity_0": ("xyz",), "px4/sensor_combined_0": ("gyro_rad",),
    "px4/vehicle_angular_velocity_groundtruth_0": ("xyz",), "ardupilot/IMU_0": _GYRO, "ardupilot/IMU": _GYRO,
    "ardupilot/RATE": ("R", "P", "Y"),
}  # fmt: skip
"""Topics with body rates, the best first, and their fields; the controller's, in degrees, where no gyroscope is logged."""
_LARGEST = np.uint64(np.iinfo(np.int64).max)
"""Recordings hold no larger integer."""


@dataclass(frozen=True)
class LogTopic:
    """Messages of one kind."""

    time: Array  # since the autopilot's start, by its own clock, shape (m,) [s]
    fields: Mapping[str, NDArray[Any]]  # by name, each of m rows, in the log's own units and axes


@dataclass(frozen=True)
class FlightLog:
    """What a log holds."""

    autopilot: str
    """`px4` or `ardupilot`."""
    topics: Mapping[str, LogTopic]
    """By name, such as `px4/vehicle_attitude_0`."""
    rate_time: Array
    """Times of the body rates, shape (m,) [s]."""
    body_rates: Array
    """In the body frame, x forward, z up, shape (m, 3) [rad/s]; no rows where the log has none."""
    companion_offsets: Array
    """Autopilot's clock minus a companion's monotonic one, as the autopilot has estimated it, shape (k,) [s]."""
    damaged: Mapping[str, int]
    """How many messages were left out for their times, by topic; `the file`: how often what came was no message."""


@dataclass(frozen=True)
class LogRows:
    """Messages of one topic, in the order of the log."""

    stamps: NDArray[Any]  # since the autopilot's start, shape (m,) [µs]
    fields: Mapping[str, NDArray[Any]]  # by name, each of m rows


def flight_log(autopilot: str, file: Path, logged: Mapping[str, LogRows], bad: int) -> FlightLog:
    """A log of what was read, and of how often what came was no message."""
    if not logged:
        raise RecordingError("no message in the log has a time", file=file, allowed="a log of an autopilot that flew")
    topics, damaged = _timed_topics(logged)
    clock, offsets = topics.get("px4/timesync_status_0"), np.empty(0)
    if clock is not None and "estimated_offset" in clock.fields:
        offsets = clock.fields["estimated_offset"].astype(np.float64) * 1e-6
    damaged |= {"the file": bad} if bad else {}
    return FlightLog(autopilot, topics, *_body_rates(topics), offsets[offsets != 0.0], damaged)


def _body_rates(topics: Mapping[str, LogTopic]) -> tuple[Array, Array]:
    """Times and body rates, x forward, z up; a log has x forward, y right, z down."""
    for name, fields in _RATES.items():
        if name in topics and set(fields) <= set(topics[name].fields):
            rates = np.column_stack([topics[name].fields[field] for field in fields])
            unit = math.radians(1.0) if name == "ardupilot/RATE" else 1.0
            if rates.shape[1] == 3:
                with np.errstate(invalid="ignore"):  # NaN of single precision stays NaN
                    return topics[name].time, rates * np.array([unit, -unit, -unit])
    return np.empty(0), np.empty((0, 3))


def _timed_topics(logged: Mapping[str, LogRows]) -> tuple[dict[str, LogTopic], dict[str, int]]:
    """Topics in the order of their times, and how many messages of which were left out."""
    # A damaged time goes ahead of all that follow, or behind all before; or it is hours from the middle of the log.
    times = {name: rows.stamps.astype(np.float64) * 1e-6 for name, rows in logged.items()}
    good = {name: _in_order(time) for name, time in times.items()}
    every = np.concatenate([np.empty(0), *(times[name][good[name]] for name in times)])
    middle = float(np.median(every)) if len(every) else 0.0
    topics, damaged = {}, {}
    for name, rows in logged.items():
        kept = np.flatnonzero(good[name] & (np.abs(times[name] - middle) <= LONGEST))
        if lost := len(times[name]) - len(kept):
            damaged[name] = lost
        kept = kept[np.argsort(times[name][kept], kind="stable")]
        if len(kept):
            fields = {field: _recordable(values[kept]) for field, values in rows.fields.items()}
            if "time" in fields:  # a recording's own
                fields["time_"] = fields.pop("time")
            topics[name] = LogTopic(times[name][kept], fields)
    return topics, damaged


def texts(values: Iterable[bytes]) -> NDArray[np.str_]:
    """Texts that end with a zero, or fill their field."""
    return np.array([value.split(b"\0")[0].decode(errors="replace") for value in values], dtype=np.str_)


def _in_order(time: Array, jitter: float = 5.0) -> NDArray[np.bool_]:
    """Which belong to the longest row of times that never goes back, or stand beside it by no more than the jitter [s]."""
    if (np.diff(time) >= -jitter).all():
        return np.ones(len(time), dtype=bool)
    row = _longest_row(time)
    place = np.searchsorted(row, np.arange(len(time)))
    bounded = np.concatenate(([-np.inf], time[row], [np.inf]))
    before, behind = bounded[place], bounded[np.searchsorted(row, np.arange(len(time)), side="right") + 1]
    return np.asarray((time >= before - jitter) & (time <= behind + jitter))


def _longest_row(time: Array) -> NDArray[np.int64]:
    """Places of the longest row that never goes back, by patience sorting."""
    lowest: list[float] = []
    ends: list[int] = []
    before = np.full(len(time), -1)
    for place, value in enumerate(time.tolist()):
        length = bisect_right(lowest, value)
        before[place] = ends[length - 1] if length else -1
        lowest[length : length + 1], ends[length : length + 1] = [value], [place]
    row, place = [], ends[-1]
    while place >= 0:
        row.append(place)
        place = int(before[place])
    return np.array(row[::-1])


def _recordable(values: NDArray[Any]) -> NDArray[Any]:
    """In the machine's byte order, and without unsigned 64-bit numbers, which recordings do not hold."""
    if values.dtype.kind == "u" and values.dtype.itemsize == 8:
        return np.asarray(np.minimum(values, _LARGEST).astype(np.int64))
    return values.astype(values.dtype.newbyteorder("="))
