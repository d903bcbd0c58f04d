"""A run and an autopilot's log in one file: how the log is read, on which clock it lies, and how both are written."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from doorman.bounds import LAST_TIME
from doorman.exceptions import RecordingError
from doorman.recording.merging.alignment import Alignment, align_by_rates
from doorman.recording.merging.ardupilot_log import read_ardupilot_log
from doorman.recording.merging.flight_log import FlightLog
from doorman.recording.merging.px4_log import read_px4_log
from doorman.recording.recorder import Recorder
from doorman.recording.recording import Recording

CLOCK = "clock"
"""Topic with the autopilot's clock as the run's adapter has mapped it."""
_ULOG = b"ULog\x01\x12\x35"
_DATAFLASH = b"\xa3\x95"
_RATES = ("measurement", "truth")
"""Topics of a run with body rates, the better first."""


def read_log(file: Path) -> FlightLog:
    """Read a PX4 ULog or an ArduPilot DataFlash log; the content decides which.

    Args:
        file: The log.

    Returns:
        Everything in it that has a time.

    Raises:
        RecordingError: if it cannot be read, or is neither.
    """
    try:
        with file.open("rb") as stream:
            head = stream.read(len(_ULOG))
    except OSError as error:
        raise RecordingError(f"cannot be read: {error.strerror}", file=file) from error
    if head == _ULOG:
        return read_px4_log(file)
    if head.startswith(_DATAFLASH):
        return read_ardupilot_log(file)
    allowed = "a PX4 ULog (.ulg) or a binary ArduPilot DataFlash log (.bin)"
    raise RecordingError("unknown kind of log", file=file, given=repr(head), allowed=allowed)


def align(recording: Recording, log: FlightLog) -> Alignment:
    """Where a log lies on a run's clock: by TIMESYNC as the run or the log has recorded it, else by the rates.

    Args:
        recording: Of the run.
        log: Of the autopilot that flew it.

    Raises:
        RecordingError: if nothing tells.
    """
    if "epoch" in recording:
        epoch = float(recording["epoch"]["epoch"][-1])
        if CLOCK in recording and math.isfinite(recording[CLOCK]["autopilot_offset"][-1]):
            clock = recording[CLOCK]
            trip = float(clock["round_trip"][-1])
            return Alignment(float(clock["autopilot_offset"][-1]) - epoch, 0.5 * trip, "TIMESYNC in the run")
        if len(log.companion_offsets):
            offsets = log.companion_offsets
            return Alignment(-float(np.median(offsets)) - epoch, float(np.std(offsets)), "TIMESYNC in the log")
    for topic in _RATES:
        if topic in recording and "body_rates" in recording[topic]:
            found = recording[topic]
            return align_by_rates(found.time, found["body_rates"], log.rate_time, log.body_rates)
    raise RecordingError("the run has no body rates", field="topic", given=", ".join(recording),
                         allowed=f"one of {', '.join(_RATES)}; or --offset")  # fmt: skip


def write_merged(recording: Recording, log: FlightLog, alignment: Alignment, file: Path) -> dict[str, int]:
    """Write run and log into one recording.

    Times of a recording are not negative: what the log tells of the time before the run's zero is left out.

    Args:
        recording: Of the run; its topics, header and attachments are kept.
        log: Its messages become further topics.
        alignment: Of the log's clock.
        file: Where to; replaced if it exists.

    Returns:
        Messages written by topic of the log.

    Raises:
        RecordingError: if nothing of the log lies within the run, or the file cannot be written.
    """
    columns: list[tuple[str, Any, Any]] = [(name, topic.time, dict(topic)) for name, topic in recording.items()]
    counts = {}
    for name, topic in log.topics.items():
        time = alignment.to_run(topic.time)
        kept = (time >= 0.0) & (time <= LAST_TIME)
        if kept.any() and name not in recording:
            columns.append((name, time[kept], {field: values[kept] for field, values in topic.fields.items()}))
            counts[name] = int(kept.sum())
    if not counts:
        raise RecordingError("nothing of the log lies within the run", field="offset", given=alignment.offset)
    merged = {"autopilot": log.autopilot, "offset": alignment.offset, "by": alignment.by}
    deviation = alignment.deviation if math.isfinite(alignment.deviation) else None
    header = recording.header | {"merged": merged | {"deviation": deviation}}
    with Recorder(file, header, keep=False, attachments=recording.attachments) as recorder:
        for name, at, fields in _in_order(columns):
            recorder.write(name, at, fields)
    return counts


def _in_order(columns: list[tuple[str, Any, Any]]) -> Iterator[tuple[str, float, dict[str, Any]]]:
    """All messages by time; those of one time in the order of their topics."""
    times = np.concatenate([time for _, time, _ in columns])
    topics = np.concatenate([np.full(len(time), number) for number, (_, time, _) in enumerate(columns)])
    rows = np.concatenate([np.arange(len(time)) for _, time, _ in columns])
    for place in np.argsort(times, kind="stable"):
        name, _, fields = columns[topics[place]]
        row = rows[place]
        yield name, float(times[place]), {field: values[row] for field, values in fields.items()}
