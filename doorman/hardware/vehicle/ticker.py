"""Ticks of the controller by the monotonic clock, and how even they were."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doorman.clocks import REAL_TIME, Clock

_KEPT = 200_000


@dataclass(frozen=True)
class TickStatistics:
    """Periods between ticks as they were."""

    ticks: int
    missed: int  # ticks that were left out since the one before took too long
    median: float  # of the periods [s]
    p99_9: float  # 99.9th percentile of |period − nominal| [s]
    longest: float  # longest period [s]


class Ticker:
    """Waits for the next tick; a tick that has passed already is left out, not made up for."""

    def __init__(self, period: float, clock: Clock = REAL_TIME) -> None:
        self.period, self._clock = period, clock
        self._next: float | None = None
        self._last = 0.0
        self.missed = 0  # ticks that were left out
        self.periods: list[float] = []  # between ticks, the first of them [s]

    def wait(self) -> float:
        now = self._clock.now()
        if self._next is None:
            self._next = self._last = now
            return now
        self._next += self.period
        if now > self._next:
            late = int((now - self._next) / self.period)
            self.missed += late
            self._next += late * self.period
        self._clock.reach(self._next)
        now = self._clock.now()
        if now > self._last and len(self.periods) < _KEPT:
            self.periods.append(now - self._last)
        self._last = now
        return now

    def statistics(self) -> TickStatistics:
        periods = np.array(self.periods or [self.period])
        return TickStatistics(
            ticks=len(self.periods) + 1,
            missed=self.missed,
            median=float(np.median(periods)),
            p99_9=float(np.percentile(np.abs(periods - self.period), 99.9)),
            longest=float(periods.max()),
        )
