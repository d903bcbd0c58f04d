"""Merging: an autopilot's own log beside a run's recording, on one clock."""

from doorman.recording.merging.alignment import Alignment
from doorman.recording.merging.flight_log import FlightLog
from doorman.recording.merging.merge import align, read_log, write_merged

__all__ = ["Alignment", "FlightLog", "align", "read_log", "write_merged"]
