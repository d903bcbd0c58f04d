"""Commands on their way: so many at most in a time, each late by a constant and by chance."""

from __future__ import annotations

import copy
import math
from collections import deque
from typing import Generic, TypeVar

import numpy as np

Sent = TypeVar("Sent")

_OWN = 67
"""Keeps its draws apart from those of sensors and gusts of the same seed."""
ROUNDED = 1e-9
"""Rounding error of a sum of periods [s]."""


class DelayLine(Generic[Sent]):
    """Commands that arrive later than they were sent; none overtakes another."""

    def __init__(self, delay: float = 0.0, jitter: float = 0.0, rate: float | None = None, seed: int = 0) -> None:
        self._delay, self._jitter = delay, jitter
        self._interval = 0.0 if rate is None else 1.0 / rate
        self._draw = np.random.default_rng([seed, _OWN])
        self._on_the_way: deque[tuple[float, Sent]] = deque()
        self._next = 0.0

    def shifted(self, by: float) -> DelayLine[Sent]:
        """The same on its way, by a clock that begins so much later."""
        other = copy.deepcopy(self)
        other._on_the_way = deque((arrives - by, command) for arrives, command in self._on_the_way)
        other._next -= by
        return other

    @property
    def is_plain(self) -> bool:
        """Whether every command is there at once."""
        return self._delay == self._jitter == self._interval == 0.0

    @property
    def due(self) -> float:
        """When the next command arrives; ∞ if none is on its way."""
        return self._on_the_way[0][0] if self._on_the_way else math.inf

    def send(self, now: float, command: Sent) -> None:
        """Send a command, unless the last one was sent too short a time ago."""
        if now < self._next - ROUNDED:
            return
        self._next = max(self._next + self._interval, now)
        arrives = now + self._delay
        if self._jitter:
            arrives += self._jitter * float(self._draw.random())
        self._on_the_way.append((arrives, command))

    def arrived(self, now: float) -> Sent | None:
        """The newest command that has arrived and was not handed out before."""
        newest, on_the_way = None, self._on_the_way
        while on_the_way and on_the_way[0][0] <= now + ROUNDED:
            newest = on_the_way.popleft()[1]
        return newest
