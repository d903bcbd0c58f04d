"""Reads an autopilot's log of either kind."""

from __future__ import annotations

from pathlib import Path

from doorman.exceptions import RecordingError
from doorman.recording.merging.ardupilot_log import read_ardupilot_log
from doorman.recording.merging.flight_log import FlightLog
from doorman.recording.merging.px4_log import read_px4_log

_ULOG = b"ULog\x01\x12\x35"
_DATAFLASH = b"\xa3\x95"


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
