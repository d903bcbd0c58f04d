"""How the stream ran: rates, gaps and delays, measured on what was received."""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from doorman.hardware.mocap.faults import MocapFault
from doorman.position_noise import PositionNoise

_KEPT = 1000


@dataclass(frozen=True)
class MocapStatistics:
    """Figures since `open`; medians and percentiles are over the last thousand frames, NaN before there are any."""

    packets: int
    """Datagrams received."""
    frames: int
    """Frames of the stream, each counted once."""
    poses: int
    """Poses that were used."""
    dropped: int
    """Frames whose packets did not come."""
    counts: Mapping[MocapFault, int]
    """How often every fault has struck or begun."""
    frame_rate: float
    """Measured [1/s]."""
    interval: float
    """Median time between two arrivals [s]."""
    jitter: float
    """Within which 90 % of these times lie around their median [s]."""
    delay: float
    """Median time by which packets arrive later than the quickest, by frame numbers and rate [s]."""
    delay_p99: float
    """[s]."""
    delay_max: float
    """[s]."""
    latency: float
    """Median time from exposure to arrival: the configured one of the quickest packets and `delay` [s]."""
    velocity_lag: float
    """Median of the velocity filter's lag [s]."""
    position_noise: float = math.nan
    """White noise of a position on every axis, by second differences, which motion does not show in [m]."""


class Figures:
    """Collects what `MocapStatistics` tells; written by one thread."""

    def __init__(self) -> None:
        self.packets = 0
        self.frames = 0
        self.poses = 0
        self.dropped = 0
        self._arrival: float | None = None
        self._intervals: deque[float] = deque(maxlen=_KEPT)
        self._delays: deque[float] = deque(maxlen=_KEPT)
        self._lags: deque[float] = deque(maxlen=_KEPT)
        self._noise = PositionNoise()

    def frame(self, arrival: float, delay: float, skipped: int) -> None:
        """A new frame arrived."""
        self.frames += 1
        self.dropped += skipped
        if self._arrival is not None:
            self._intervals.append(arrival - self._arrival)
        self._arrival = arrival
        self._delays.append(delay)

    def pose(self, lag: float, frame: int, position: Sequence[float]) -> None:
        """Count a pose that was used."""
        self.poses += 1
        self._lags.append(lag)
        self._noise.note(frame, position)

    def statistics(self, counts: Mapping[MocapFault, int], frame_rate: float, latency: float) -> MocapStatistics:
        """Figures so far."""
        intervals, delays, lags = list(self._intervals), list(self._delays), list(self._lags)
        middle = _median(intervals)
        late, latest = np.percentile(delays, (99.0, 100.0)) if delays else (math.nan, math.nan)
        jitter = float(np.percentile(np.abs(np.array(intervals) - middle), 90.0)) if intervals else math.nan
        return MocapStatistics(
            self.packets, self.frames, self.poses, self.dropped, dict(counts), frame_rate, middle, jitter,
            _median(delays), float(late), float(latest), latency + _median(delays), _median(lags), self._noise.deviation,
        )  # fmt: skip


def _median(values: list[float]) -> float:
    return statistics.median(values) if values else math.nan
