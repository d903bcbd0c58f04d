"""ArduPilot's binary DataFlash log, read by `pymavlink`: messages with their instances, and the gyroscope's rates."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymavlink.DFReader import DFReader_binary

from doorman.exceptions import RecordingError
from doorman.recording.merging.flight_log import Array, FlightLog, LogTopic
from doorman.recording.merging.frames import from_forward_right_down

_MICRO = 1e-6
_TIME = "TimeUS"
_GYRO = ("GyrX", "GyrY", "GyrZ")
_RATES = ("R", "P", "Y")


def read_ardupilot_log(file: Path) -> FlightLog:
    """Read a DataFlash log.

    Args:
        file: The log.

    Raises:
        RecordingError: if it is damaged beyond reading, or nothing in it has a time.
    """
    rows: dict[str, list[dict[str, Any]]] = {}
    try:
        with closing(DFReader_binary(str(file))) as log:
            while (message := log.recv_msg()) is not None:
                if _TIME in message.fmt.columns:
                    rows.setdefault(_name(message), []).append(_row(message))
    except Exception as error:  # the parser raises whatever it stumbles over
        raise RecordingError(f"not a readable DataFlash log: {type(error).__name__}: {error}", file=file) from error
    if not rows:
        raise RecordingError("no message in the log has a time", file=file, allowed=f"messages with {_TIME}")
    topics = {name: _topic(messages) for name, messages in rows.items()}
    return FlightLog("ardupilot", topics, *_rates(topics), np.empty(0))


def _name(message: Any) -> str:
    """Topic of a message; sensors of one kind are told apart by their instance."""
    field = message.fmt.instance_field
    return f"ardupilot/{message.get_type()}" + ("" if field is None else f"_{getattr(message, field)}")


def _row(message: Any) -> dict[str, Any]:
    return {column: getattr(message, column) for column in message.fmt.columns}


def _topic(messages: list[dict[str, Any]]) -> LogTopic:
    time = np.array([message[_TIME] for message in messages], dtype=np.float64) * _MICRO
    order = np.argsort(time, kind="stable")
    names = [name for name in messages[0] if name != _TIME]
    columns = {name: _column([message[name] for message in messages]) for name in names}
    return LogTopic(time[order], {name: values[order] for name, values in columns.items()})


def _column(values: list[Any]) -> NDArray[Any]:
    """Numbers as they are; bytes and whatever else has no type of its own as text."""
    if isinstance(values[0], bytes):
        return np.array([value.split(b"\0")[0].decode(errors="replace") for value in values])
    column = np.array([0.0 if value is None else value for value in values] if values[0] is None else values)
    if column.dtype.kind in "fib" or column.dtype.kind == "U":
        return column
    if column.dtype.kind == "u":
        return column.astype(np.int64)
    return np.array([str(value) for value in values])


def _rates(topics: Mapping[str, LogTopic]) -> tuple[Array, Array]:
    """Of the first gyroscope [rad/s]; of the controller, in degrees, where no gyroscope is logged."""
    for name in ("ardupilot/IMU_0", "ardupilot/IMU"):
        if name in topics and set(_GYRO) <= set(topics[name].fields):
            return topics[name].time, _stacked(topics[name], _GYRO)
    topic = topics.get("ardupilot/RATE")
    if topic is not None and set(_RATES) <= set(topic.fields):
        return topic.time, np.radians(_stacked(topic, _RATES))
    return np.empty(0), np.empty((0, 3))


def _stacked(topic: LogTopic, names: tuple[str, ...]) -> Array:
    return from_forward_right_down(np.stack([topic.fields[name].astype(np.float64) for name in names], axis=1))
