"""The emulated autopilot's clock, and how it maps the companion's to it."""

from __future__ import annotations

import math

from doorman.clocks import REAL_TIME, Clock

_BOOT = 3.0
"""Reading of the clock when the link comes up [s]."""
_ANSWERS_NEEDED = 20
"""Answers to TIMESYNC before PX4 trusts its mapping."""


class BootClock:
    def __init__(self, pace: float = 1.0, time: Clock = REAL_TIME) -> None:
        self.jumped = 0.0  # by which it has jumped since boot; may be set at any time [s]
        self._pace, self._time, self._started = pace, time, time.now()

    @property
    def uptime(self) -> float:
        """Since boot, by which it counts its own time-outs: that never jumps [s]."""
        return _BOOT + (self._time.now() - self._started) * self._pace

    @property
    def now(self) -> float:
        """What its messages are stamped with [s]."""
        return self.uptime + self.jumped


class CompanionClock:
    """Maps stamps of a companion to the autopilot's clock, the way the two autopilots do it."""

    def __init__(self, by_timesync: bool) -> None:
        self.answers, self.offset = 0, 0.0  # answers so far, and the autopilot's clock minus the companion's [s]
        self._by_timesync, self._least = by_timesync, math.inf

    def answer(self, sent_ns: int, companion_ns: int, now_ns: int) -> None:
        offset = ((sent_ns + now_ns) / 2 - companion_ns) * 1e-9
        self.offset = offset if self.answers == 0 else 0.8 * self.offset + 0.2 * offset
        self.answers += 1

    def stamp(self, companion_us: int, now: float) -> float:
        """Time of a companion's stamp on the autopilot's clock [s]."""
        stamp = companion_us * 1e-6
        if self._by_timesync:
            return stamp + self.offset if self.answers >= _ANSWERS_NEEDED else now
        self._least = min(self._least + 1e-5, now - stamp)
        return stamp + self._least
