r"""The autopilot's clock on this computer's, by TIMESYNC.

A request carries our time :math:`t_1`, its answer the autopilot's :math:`T`; back at :math:`t_2`,

.. math:: t = T + o, \qquad o = \tfrac12 (t_1 + t_2) - T, \qquad |\text{error}| \le \tfrac12 (t_2 - t_1)

The offset is a straight line through the quicker half of a window of such samples, so that a clock that runs at another rate
is followed too. Samples off the line are kept aside: enough of them in a row on a line of their own mean that a clock jumped.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

_WINDOW = 40
_ENOUGH = 4
"""Samples before anything is mapped, and outliers in a row that make a jump."""
_GATE = 0.003
"""Deviation from the line that is never called an outlier [s]; half the sample's round trip comes on top."""
_JUMP = 0.02
"""Change of the line that is worth a word [s]."""
_LEVEL_SPAN = 1.0
"""Shorter windows do not tell a slope from noise, unless it is steep [s]."""
_FOLLOW = _LEVEL_SPAN / 2
"""Longest round trip of use, and time for which the slope is followed after the newest sample [s]."""
_LEAST_SPAN = _LEVEL_SPAN / 20
"""Shorter windows tell no slope at all [s]."""
_MAX_PENDING = 32


class Sample(NamedTuple):
    """One answered request; seconds."""

    local: float  # middle of the round trip on our clock
    offset: float
    round_trip: float


class SyncResult(Enum):
    UNASKED = "not an answer to our request"
    SLOW = "round trip too long"
    ACCEPTED = "accepted"
    OUTLIER = "off the line"
    JUMPED = "the clock jumped"
    REBOOTED = "the autopilot's clock started anew"


@dataclass(frozen=True)
class _Line:
    reference: float
    offset: float
    slope: float
    end: float  # beyond which the slope is not followed: it was measured over a short time

    def at(self, local: float) -> float:
        return self.offset + self.slope * (min(local, self.end) - self.reference)


class ClockMap:
    def __init__(self) -> None:
        self._pending: deque[int] = deque(maxlen=_MAX_PENDING)
        self._samples: deque[Sample] = deque(maxlen=_WINDOW)
        self._outliers: deque[Sample] = deque(maxlen=_ENOUGH)
        self.reset()

    def reset(self) -> None:
        for queue in (self._pending, self._samples, self._outliers):
            queue.clear()
        self._line: _Line | None = None
        self._newest_remote, self._backwards = float("-inf"), 0
        self.last_update, self.round_trip = float("-inf"), float("nan")  # other threads read these, not the queues

    @property
    def synchronised(self) -> bool:
        return self._line is not None

    def offset(self, local: float) -> float:
        """Offset of our clock from the autopilot's [s]; NaN before the first samples."""
        line = self._line
        return float("nan") if line is None else line.at(local)

    def to_local(self, remote: float, now: float) -> float:
        """Time on our clock of a stamp of the autopilot, never later than `now`; `now` while not synchronised [s]."""
        line = self._line
        if line is None:
            return now
        return min(now, remote + line.at(min(now, remote + line.at(now))))

    def ahead(self, remote: float, now: float) -> float:
        """How far a stamp of the autopilot lies after `now` [s]; −∞ while not synchronised."""
        line = self._line
        return float("-inf") if line is None else remote + line.at(now) - now

    def ask(self, now_ns: int) -> int:
        """Value for a request's `ts1`, to be recognised in its answer."""
        self._pending.append(now_ns)
        return now_ns

    def answer(self, ts1: int, tc1: int, now_ns: int) -> SyncResult:
        if ts1 not in self._pending:
            return SyncResult.UNASKED
        self._pending.remove(ts1)
        round_trip = (now_ns - ts1) * 1e-9
        if not 0.0 <= round_trip <= _FOLLOW:
            return SyncResult.SLOW
        remote = tc1 * 1e-9
        local = ts1 * 1e-9 + 0.5 * round_trip
        sample = Sample(local, local - remote, round_trip)
        if remote >= self._newest_remote - round_trip - _GATE:
            self._newest_remote, self._backwards = max(self._newest_remote, remote), 0
            return self._take(sample)
        self._backwards += 1
        if self._backwards < 2:  # answers that overtake each other do not go backwards twice in a row
            return SyncResult.OUTLIER
        self.reset()
        self._accept(sample)
        return SyncResult.REBOOTED

    def _take(self, sample: Sample) -> SyncResult:
        line = self._line
        if line is None or abs(sample.offset - line.at(sample.local)) <= _gate(sample):
            self._accept(sample)
            self._outliers.clear()
            return SyncResult.ACCEPTED
        self._outliers.append(sample)
        if len(self._outliers) < _ENOUGH:
            return SyncResult.OUTLIER
        fitted = _fit(list(self._outliers))
        if fitted is None:
            return SyncResult.OUTLIER
        jump = fitted.at(sample.local) - line.at(sample.local)
        self._samples.clear()
        self._samples.extend(self._outliers)
        self._outliers.clear()
        self._line = fitted
        self._note()
        return SyncResult.JUMPED if abs(jump) > _JUMP else SyncResult.ACCEPTED

    def _accept(self, sample: Sample) -> None:
        self._samples.append(sample)
        self._note()
        if len(self._samples) < _ENOUGH:
            return
        ordered = sorted(self._samples, key=lambda one: one.round_trip)
        self._line = _fit(ordered[: max(_ENOUGH, len(ordered) // 2)]) or self._line

    def _note(self) -> None:
        self.last_update = self._samples[-1].local
        self.round_trip = float(np.median([sample.round_trip for sample in self._samples]))


def _gate(sample: Sample) -> float:
    return _GATE + 0.5 * sample.round_trip


def _fit(samples: list[Sample]) -> _Line | None:
    local = np.array([sample.local for sample in samples])
    offset = np.array([sample.offset for sample in samples])
    gates = np.array([_gate(sample) for sample in samples])
    reference, newest = float(local.mean()), float(local.max())
    span = newest - float(local.min())
    median = float(np.median(offset))
    slack = float(np.median(gates))  # what is compared with is no surer than the answers that it is made of
    if span < _LEVEL_SPAN and (np.abs(offset - median) <= gates + slack).all():
        return _Line(reference, median, 0.0, newest)
    if span < _LEAST_SPAN:
        return None
    spread = local - reference
    slope = float(spread @ (offset - offset.mean()) / (spread @ spread))
    line = _Line(reference, float(offset.mean()), slope, newest + _FOLLOW)
    return line if (np.abs(offset - line.offset - slope * spread) <= gates + slack).all() else None
