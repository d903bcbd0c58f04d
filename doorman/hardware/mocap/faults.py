"""What can be wrong with the poses and the stream that brings them, the log of it, and figures of how the stream ran."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Flag, auto

import numpy as np

from doorman.arrays import Array
from doorman.background import EventLog
from doorman.position_noise import PositionNoise


class MocapFault(Flag):
    """What is wrong; several may hold at once."""

    NONE = 0

    DROPPED = auto()
    """Frame numbers are missing: packets were lost."""
    DUPLICATED = auto()
    """A packet came twice."""
    REORDERED = auto()
    """A packet came after a newer one."""
    CORRUPT = auto()
    """A datagram is no packet of the stream, or holds impossible numbers."""
    FOREIGN = auto()
    """Somebody else sends to our port."""
    NUMBERING = auto()
    """Frame numbers do not fit the time that has passed."""
    RESTARTED = auto()
    """The frame numbers began anew; how late the poses are since then is not known from them."""
    MISSING = auto()
    """Packets come, but the object is not in them."""
    OCCLUDED = auto()
    """The object's pose repeats to the last bit, or is all zeros: the cameras do not see it."""
    OUTLIER = auto()
    """A pose lies beyond what speed and acceleration allow."""
    JUMPED = auto()
    """The object is seen where it cannot have moved to."""
    DELAYED = auto()
    """Poses arrive late."""
    RATE = auto()
    """Frames do not come at the configured rate, so that their numbers do not tell the time."""
    SILENT = auto()
    """No packets come."""
    STALE = auto()
    """No new pose for `stale_after`: poses are predicted."""
    LOST = auto()
    """No new pose for `prediction_limit`: there is no pose to fly on."""
    SOCKET = auto()
    """The socket failed."""
    INTERNAL = auto()
    """The adapter itself failed."""
    CLIENT = auto()
    """The process that speaks to the cameras ended; it is started again."""


DISCARDING = (
    MocapFault.DUPLICATED
    | MocapFault.REORDERED
    | MocapFault.CORRUPT
    | MocapFault.FOREIGN
    | MocapFault.NUMBERING
    | MocapFault.OCCLUDED
    | MocapFault.OUTLIER
    | MocapFault.RATE
)
"""What is received under them is not used."""


@dataclass(frozen=True)
class MocapEvent:
    """A fault that began or ended, or something worth knowing."""

    time: float
    """By `time.monotonic` [s]."""
    fault: MocapFault
    """Which; `NONE` where nothing is wrong."""
    began: bool
    """False where it ended."""
    text: str
    """What happened, in words."""

    def __str__(self) -> str:
        return f"mocap: {self.text}"


class FaultBook:
    """Faults that hold now. Those that strike single packets hold until they have not struck for a while."""

    def __init__(self, log: EventLog[MocapEvent], hold: float) -> None:
        self._log, self._hold = log, hold
        self._ends: dict[MocapFault, float] = {}
        self.holds = MocapFault.NONE  # everything that is wrong now; replaced as a whole
        self.counts: Counter[MocapFault] = Counter()  # how often each has struck or begun

    def strike(self, fault: MocapFault, now: float, text: str) -> None:
        """A single packet shows a fault."""
        self.counts[fault] += 1
        self._ends[fault] = now + self._hold
        self._change(fault, True, now, text)

    def keep(self, fault: MocapFault, holds: bool, now: float, text: str = "") -> None:
        """Begin or end a lasting fault; nothing happens if that is how it is already."""
        if holds and not fault & self.holds:
            self.counts[fault] += 1
        self._change(fault, holds, now, text)

    def note(self, now: float, text: str) -> None:
        """Write down what is worth knowing and is no fault."""
        self._log.write(MocapEvent(now, MocapFault.NONE, True, text))

    def tick(self, now: float) -> None:
        """Let faults end that have not struck for a while."""
        for fault in [fault for fault, end in self._ends.items() if end <= now]:
            del self._ends[fault]
            self._change(fault, False, now, "")

    @property
    def deadline(self) -> float:
        """When the next fault ends if it does not strike again [s]; ∞ if there is none."""
        return min(self._ends.values(), default=float("inf"))

    def _change(self, fault: MocapFault, holds: bool, now: float, text: str) -> None:
        if holds == bool(fault & self.holds):
            return
        self.holds = self.holds | fault if holds else self.holds & ~fault
        name = (fault.name or "").lower()
        tail = f": {text}" if text else ""
        self._log.write(MocapEvent(now, fault, holds, f"{name} {'began' if holds else 'ended'}{tail}"))


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
        self.packets = self.frames = self.poses = self.dropped = 0
        self._arrivals: deque[float] = deque(maxlen=_KEPT + 1)
        self._delays: deque[float] = deque(maxlen=_KEPT)
        self._lags: deque[float] = deque(maxlen=_KEPT)
        self._noise = PositionNoise()

    def frame(self, arrival: float, delay: float, skipped: int) -> None:
        self.frames += 1
        self.dropped += skipped
        self._arrivals.append(arrival)
        self._delays.append(delay)

    def pose(self, lag: float, frame: int, position: Sequence[float]) -> None:
        self.poses += 1
        self._lags.append(lag)
        self._noise.note(frame, position)

    def statistics(self, counts: Mapping[MocapFault, int], frame_rate: float, latency: float) -> MocapStatistics:
        intervals, delays = np.diff(list(self._arrivals)), list(self._delays) or [math.nan]
        interval, (delay, late, latest) = _median(intervals), np.percentile(delays, (50.0, 99.0, 100.0)).tolist()
        jitter = float(np.percentile(np.abs(intervals - interval), 90.0)) if len(intervals) else math.nan
        return MocapStatistics(
            self.packets, self.frames, self.poses, self.dropped, dict(counts), frame_rate, interval, jitter, delay, late,
            latest, latency + delay, _median(self._lags), self._noise.deviation,
        )  # fmt: skip


def _median(values: Sequence[float] | Array) -> float:
    return float(np.median(list(values))) if len(values) else math.nan
