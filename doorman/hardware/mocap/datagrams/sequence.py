"""Whether a packet's frame number is the next, an old one, or nonsense, judged by the time that has passed."""

from __future__ import annotations

from collections import deque
from enum import Enum

from doorman.hardware.mocap.datagrams.clock import FrameClock

EARLY = 0.02
"""So much before its time a frame may arrive, or three periods: the clock began with a packet that was late itself [s]."""
FORGIVEN = 2.0
"""So late a frame may be; what is later still belongs to a stream whose numbers began anew [s]."""
PACE = 0.03
"""Tolerance on the pace of frames that begin anew [s]."""
NEW_RUN = 10
"""Frames in a row, at the nominal rate, that make a new beginning."""
_REMEMBERED = 64
_WRAP = 1 << 32


class Order(Enum):
    """What a frame number says."""

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
            if step < 0 or abs(pace) > PACE:
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
