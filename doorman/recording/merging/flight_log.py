"""An autopilot's log, whichever autopilot wrote it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from doorman.arrays import Array


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
