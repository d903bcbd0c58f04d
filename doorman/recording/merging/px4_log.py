"""PX4's ULog, read by `pyulog`: topics with their instances, messages in words, and what tells its clock."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pyulog import ULog

from doorman.exceptions import RecordingError
from doorman.recording.merging.flight_log import Array, FlightLog, LogTopic
from doorman.recording.merging.frames import from_forward_right_down

_MICRO = 1e-6
_ENTRY = re.compile(r"(.+)\[(\d+)\]")
_RATES = (
    ("vehicle_angular_velocity", "xyz"),
    ("sensor_combined", "gyro_rad"),
    ("vehicle_angular_velocity_groundtruth", "xyz"),
)
"""Topics with body rates and their field, the best first."""


def read_px4_log(file: Path) -> FlightLog:
    """Read a ULog.

    Args:
        file: The log.

    Raises:
        RecordingError: if it is damaged beyond reading.
    """
    try:
        with file.open("rb") as stream:
            log = ULog(stream)
    except Exception as error:  # the parser raises whatever it stumbles over
        raise RecordingError(f"not a readable ULog: {type(error).__name__}: {error}", file=file) from error
    topics = {
        f"px4/{data.name}_{data.multi_id}": _topic(data.data) for data in log.data_list if len(data.data["timestamp"])
    }
    if log.logged_messages:
        times = np.array([one.timestamp for one in log.logged_messages]) * _MICRO
        words = np.array([f"{one.log_level_str()}: {one.message}" for one in log.logged_messages])
        topics["px4/logged_messages"] = LogTopic(times, {"message": words})
    rate_time, rates = _rates(topics)
    return FlightLog("px4", topics, rate_time, rates, _companion_offsets(topics))


def _topic(data: Mapping[str, NDArray[Any]]) -> LogTopic:
    """Fields with entries `name[0]`, `name[1]`, … become one array."""
    fields: dict[str, list[NDArray[Any]]] = {}
    for name, values in data.items():
        if name == "timestamp":
            continue
        found = _ENTRY.fullmatch(name)
        fields.setdefault(found[1] if found else name, []).append(_recordable(values))
    time = data["timestamp"] * _MICRO
    columns = {name: np.stack(parts, axis=1) if len(parts) > 1 else parts[0] for name, parts in fields.items()}
    order = np.argsort(time, kind="stable")
    return LogTopic(time[order], {_free(name): values[order] for name, values in columns.items()})


def _free(name: str) -> str:
    """A name that a recording's own fields leave free."""
    return "time_" if name == "time" else name


def _recordable(values: NDArray[Any]) -> NDArray[Any]:
    """Without unsigned 64-bit numbers, which recordings do not hold."""
    if values.dtype == np.uint64:
        return np.asarray(np.minimum(values, np.uint64(np.iinfo(np.int64).max)).astype(np.int64))
    return values


def _rates(topics: Mapping[str, LogTopic]) -> tuple[Array, Array]:
    for name, field in _RATES:
        topic = topics.get(f"px4/{name}_0")
        if topic is not None and field in topic.fields:
            return topic.time, from_forward_right_down(topic.fields[field].astype(np.float64))
    return np.empty(0), np.empty((0, 3))


def _companion_offsets(topics: Mapping[str, LogTopic]) -> Array:
    topic = topics.get("px4/timesync_status_0")
    if topic is None or "estimated_offset" not in topic.fields:
        return np.empty(0)
    offsets = topic.fields["estimated_offset"].astype(np.float64) * _MICRO
    return np.asarray(offsets[offsets != 0.0])
