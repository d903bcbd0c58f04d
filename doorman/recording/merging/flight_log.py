"""An autopilot's log, whichever autopilot wrote it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.exceptions import RecordingError

SUFFIXES = {".ulg": "px4", ".bin": "ardupilot", ".log": "ardupilot"}
"""Autopilot by the file's suffix, in lower case."""
_ULOG = b"ULog\x01\x12\x35"
_DATAFLASH = b"\xa3\x95"


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


def read_log(file: Path) -> FlightLog:
    """Read a PX4 ULog or an ArduPilot DataFlash log; the content decides which.

    Args:
        file: The log.

    Returns:
        Everything in it that has a time.

    Raises:
        RecordingError: if it cannot be read, or is neither.
    """
    from doorman.recording.merging.ardupilot_log import read_ardupilot_log  # both make a `FlightLog`
    from doorman.recording.merging.px4_log import read_px4_log

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
