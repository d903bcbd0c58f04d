r"""Whether a packet's frame number is the next, an old one, or nonsense, judged by the time that has passed.

Time of frames: whether they come at the rate that their numbers are read by.

With :math:`u = \text{arrival} - k T`, the deviation is :math:`\Delta u / \Delta t`: positive where frames come too slowly, or
ever later, which cannot be told apart. u is that of the quickest packet of every bin of time, and medians keep delays that set in
or end from moving the figure. The first one over 20 s of a steady stream is the cameras' rate; what changes later is delay.

When frames were taken, from their numbers: packets carry no time, and arrive late in ways that change.

Frame k arrives at the earliest at :math:`l(k) = b + k T`, where T is the period, nominal or as learnt. b follows the quickest
packets: it falls at once to where two packets in a row say that it is, and rises only as slowly as crystals drift apart, and
only while packets are hardly late. So a delay that sets in or grows, however long it lasts, is never taken for the new normal.
The frame was taken at :math:`\min(l(k), \text{arrival}) - \text{latency}`.

A clock that a time server slews would look like a queue that grows: times are those of the raw clock, which none does.
"""

from __future__ import annotations

import statistics
from collections import deque
from enum import Enum

EARLY = 0.03
"""Largest earliness of a frame, or three periods: the packet that started the clock may have been late itself. Tolerance on the
pace of frames that begin anew, too; lateness of a third of it may still be drift [s]."""
_DRIFT = 1e-4
"""Largest drift of two crystals against each other [s/s]."""


class FrameClock:
    def __init__(self, rate: float, latency: float) -> None:
        self._nominal = 1.0 / rate
        self._period = self._nominal
        self._latency = latency
        self._base = 0.0
        self._frame = 0
        self._arrival = 0.0
        self._previous = 0.0

    def start(self, frame: int, arrival: float) -> None:
        self._base, self._frame, self._arrival, self._previous = arrival, frame, arrival, 0.0

    def lateness(self, frame: int, arrival: float) -> float:
        """Time between the earliest possible and the actual arrival of a frame; negative if it is early [s]."""
        return arrival - self._base - (frame - self._frame) * self._period

    def observe(self, frame: int, arrival: float) -> float:
        late = self.lateness(frame, arrival)
        floor = max(late, self._previous)  # a single packet with a wrong number does not move the clock
        if floor < 0.0:
            moved = floor
        elif floor <= EARLY / 3:
            moved = min(floor, _DRIFT * (arrival - self._arrival))
        else:
            moved = 0.0
        self._base += (frame - self._frame) * self._period + moved
        self._frame, self._arrival, self._previous = frame, arrival, late - moved
        return max(late - moved, 0.0)

    def time_of(self, frame: int, arrival: float) -> float:
        return arrival - max(self.lateness(frame, arrival), 0.0) - self._latency

    def follow(self, deviation: float) -> None:
        """Take over a small deviation of the rate from its nominal value."""
        self._period = self._nominal * (1.0 + deviation)


GROSS = 0.02
"""Deviation over 0.8 s that is a fault."""
FINE = GROSS / 10
"""Deviation over 10 s that is a fault; smaller ones are learnt."""
_QUICK_BIN, _QUICK_BINS, _QUICK_LEAST = 0.1, 8, 3
_SETTLED = 4
"""Bins from which on a single stall does not count."""
_TRUSTED = 6
"""Bins before a deviation is called a fault."""
_EXACT_BIN, _EXACT_BINS, _EXACT_LAG, _EXACT_LEAST = 0.5, 20, 4, 8
_LEARNING_BINS, _LEARNING_LAG = 40, 8
"""Bins, and bins between the ends of a slope: noise spoils the rate less than clocks drift, a step in the delay not at all."""

Point = tuple[float, float]


class RateMonitor:
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
            spread = statistics.median(abs(slope - rate) for slope in slopes)
            if spread < _DRIFT:  # a busy computer makes it larger
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


FORGIVEN = 2.0
"""Largest lateness of a frame; later ones belong to a stream whose numbers began anew [s]."""
NEW_RUN = 10
"""Frames in a row, at the nominal rate, that make a new beginning."""
_REMEMBERED = 64
_WRAP = 1 << 32


class Order(Enum):
    NEXT = "newer than all before"
    SAME = "the newest frame once more"
    REPEATED = "an old frame once more"
    LATE = "an old frame that did not come until now"
    STRANGE = "does not fit the time"
    RESTARTED = "numbers began anew"


class FrameSequence:
    """Frame numbers of a stream, without the wrap at 2³²."""

    def __init__(self, clock: FrameClock, rate: float) -> None:
        self._clock = clock
        self._period = 1.0 / rate
        self._early = max(EARLY, 3.0 * self._period)
        self._run: list[tuple[int, float]] = []
        self._recent: deque[int] = deque(maxlen=_REMEMBERED)
        self._strides: deque[int] = deque(maxlen=16)
        self.newest: int | None = None  # newest frame; None before the first
        self.skipped = 0
        """Frames that are missing before the newest, beyond what is usual for a stream that sends every n-th."""

    def unwrapped(self, number: int) -> int:
        """The frame nearest to the newest with a number."""
        if self.newest is None:
            return number
        return self.newest + (number - self.newest + _WRAP // 2) % _WRAP - _WRAP // 2

    def classify(self, number: int, arrival: float) -> Order:
        """What a packet's frame number says; a new one becomes the newest."""
        frame = self.unwrapped(number)
        if self.newest is None:
            self._begin(frame, arrival)
            return Order.NEXT
        late = self._clock.lateness(frame, arrival)
        step = frame - self.newest
        if step > 0 and -self._early <= late <= FORGIVEN:
            self._advance(frame, step)
            return Order.NEXT
        if step == 0:
            return Order.SAME
        if step < 0 and late <= FORGIVEN:
            return Order.REPEATED if frame in self._recent else Order.LATE
        return self._stray(frame, arrival)

    def _advance(self, frame: int, step: int) -> None:
        usual = min(self._strides, default=step)
        self._strides.append(step)
        self.skipped = max(step // usual - 1, 0)
        self.newest = frame
        self._recent.append(frame)
        self._run.clear()

    def _stray(self, frame: int, arrival: float) -> Order:
        """Collect frames off the line; enough of them on a line of their own are a new beginning."""
        if self._run:
            step = frame - self._run[-1][0]
            pace = arrival - self._run[0][1] - (frame - self._run[0][0]) * self._period
            if step == 0:
                return Order.STRANGE
            if step < 0 or abs(pace) > EARLY:
                self._run.clear()
        self._run.append((frame, arrival))
        if len(self._run) < NEW_RUN:
            return Order.STRANGE
        frame, arrival = min(self._run, key=lambda one: one[1] - one[0] * self._period)
        newest = self._run[-1][0]
        self._begin(newest, arrival + (newest - frame) * self._period)
        return Order.RESTARTED

    def _begin(self, frame: int, arrival: float) -> None:
        self._clock.start(frame, arrival)
        self.newest = frame
        self.skipped = 0
        self._run.clear()
        self._recent.clear()
        self._recent.append(frame)
        self._strides.clear()
