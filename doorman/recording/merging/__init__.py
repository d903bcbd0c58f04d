"""Merging: an autopilot's own log beside a run's recording, on one clock."""

from doorman.recording.merging.alignment import Alignment
from doorman.recording.merging.flight_log import FlightLog
from doorman.recording.merging.merge import align, write_merged
from doorman.recording.merging.reading import read_log

__all__ = ["Alignment", "FlightLog", "align", "read_log", "write_merged"]
