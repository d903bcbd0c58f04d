r"""Whether frames come at the rate that their numbers are read by.

With :math:`u = \text{arrival} - k T`, the deviation is :math:`\Delta u / \Delta t`: positive where frames come too slowly, or
ever later, which cannot be told apart. u is that of the quickest packet of every bin of time, and medians keep delays that set in
or end from moving the figure. The first one over 20 s of a steady stream is the cameras' rate; what changes later is delay.
"""

from __future__ import annotations

import statistics
from collections import deque

GROSS = 0.02
"""Deviation over 0.8 s that is a fault."""
FINE = 0.002
"""Deviation over 10 s that is a fault; smaller ones are learnt."""
_STEADY = 1e-4
"""Spread of slopes (median) below which their median is the rate: a busy computer makes it larger."""
_QUICK_BIN, _QUICK_BINS, _QUICK_LEAST = 0.1, 8, 3
_SETTLED = 4
"""Bins from which on a single stall does not count."""
_TRUSTED = 6
"""Bins before a deviation is called a fault."""
_EXACT_BIN, _EXACT_BINS, _EXACT_LAG, _EXACT_LEAST = 0.5, 20, 4, 8
_LEARNING_BINS, _LEARNING_LAG = 40, 8
"""So many bins, and so long slopes, that noise spoils the rate by less than clocks drift, and a step in the delay not at all."""

Point = tuple[float, float]


class RateMonitor:
    """Compares the frames' rate with its nominal value."""

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate
        self._first: tuple[int, float] | None = None
        self._quick = _Bins(_QUICK_BIN, _QUICK_BINS)
        self._exact = _Bins(_EXACT_BIN, _LEARNING_BINS)
        self.quick: float | None = None  # deviation over the last 0.8 s; None for the first 0.3 s
        self.exact: float | None = None  # deviation over up to 10 s; None for the first 4 s
        self.learnt: float | None = None
        """Deviation of the cameras' rate: `exact`, until that over 20 s has been steady, which is kept."""
        self._settled = False

    def near(self, tolerance: float) -> bool | None:
        """Whether the rate is roughly right."""
        if self.quick is not None and abs(self.quick) <= tolerance:
            return True
        return False if len(self._quick.points) >= _SETTLED else None

    @property
    def wrong(self) -> bool:
        """Whether the deviation is too large to be learnt."""
        gross = self.quick is not None and abs(self.quick) > GROSS and len(self._quick.points) >= _TRUSTED
        return gross or (self.exact is not None and abs(self.exact) > FINE)

    @property
    def deviation(self) -> float:
        """Best known deviation; 0 while none is known."""
        if self.exact is not None and (self.quick is None or abs(self.quick) <= GROSS):
            return self.exact
        return self.quick or 0.0

    def observe(self, frame: int, arrival: float) -> bool:
        """Take in the arrival of a frame."""
        if self._first is None:
            self._first = (frame, arrival)
        elapsed = arrival - self._first[1]
        offset = elapsed - (frame - self._first[0]) * self._period
        news = self._quick.add(elapsed, offset)
        if news and len(self._quick.points) >= _QUICK_LEAST:
            self.quick = _cautious(list(self._quick.points))
        if self._exact.add(elapsed, offset) and len(self._exact.points) >= _EXACT_LEAST:
            points = list(self._exact.points)
            self.exact = statistics.median(_slopes(points[-_EXACT_BINS:], _EXACT_LAG))
            if not self._settled and not self.wrong:
                self._learn(points, self.exact)
        return news

    def _learn(self, points: list[Point], exact: float) -> None:
        self.learnt = exact
        if len(points) == _LEARNING_BINS:
            slopes = _slopes(points, _LEARNING_LAG)
            rate = statistics.median(slopes)
            if statistics.median(abs(slope - rate) for slope in slopes) < _STEADY:
                self.learnt, self._settled = rate, True


class _Bins:
    """Least offset of every bin of time."""

    def __init__(self, width: float, kept: int) -> None:
        self._width = width
        self._number = 0
        self._least: float | None = None
        self.points: deque[Point] = deque(maxlen=kept)

    def add(self, elapsed: float, offset: float) -> bool:
        """Take in an offset; returns whether a bin was completed."""
        number = int(elapsed / self._width)
        if number <= self._number:
            self._least = offset if self._least is None else min(self._least, offset)
            return False
        if self._least is not None:
            self.points.append(((self._number + 0.5) * self._width, self._least))
        self._number, self._least = number, offset
        return True


def _slopes(points: list[Point], lag: int) -> list[float]:
    return [(b[1] - a[1]) / (b[0] - a[0]) for a, b in zip(points, points[lag:], strict=False)]


def _cautious(points: list[Point]) -> float:
    """Slope that two estimates agree on: steps deceive the one over all pairs, noise the one over neighbours."""
    near = statistics.median(_slopes(points, 1))
    far = statistics.median([slope for lag in range(1, len(points)) for slope in _slopes(points, lag)])
    return 0.0 if near * far <= 0.0 else min(near, far, key=abs)
