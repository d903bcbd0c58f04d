"""The link by which commands reach the autopilot: it takes no more than so many a second, and each comes late by chance."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

import numpy as np

Sent = TypeVar("Sent")


class CommandLink(Generic[Sent]):
    """Commands on their way; none overtakes another."""

    def __init__(self, rate: float | None, jitter: float, seed: int) -> None:
        self._interval = 0.0 if rate is None else 1.0 / rate
        self._jitter, self._draw = jitter, np.random.default_rng([seed, _OWN])
        self._on_the_way: deque[tuple[float, Sent]] = deque()
        self._next = 0.0

    @property
    def is_plain(self) -> bool:
        """Whether every command is there at once."""
        return self._interval == 0.0 and self._jitter == 0.0

    def send(self, now: float, command: Sent) -> None:
        """Give it a command."""
        if now < self._next - _ROUNDED:
            return
        self._next = max(self._next + self._interval, now)
        arrives = now + self._jitter * float(self._draw.random())
        if self._on_the_way:
            arrives = max(arrives, self._on_the_way[-1][0])
        self._on_the_way.append((arrives, command))

    def arrived(self, now: float) -> Sent | None:
        """The newest command that is there by now and was not handed out before."""
        newest: Sent | None = None
        while self._on_the_way and self._on_the_way[0][0] <= now + _ROUNDED:
            newest = self._on_the_way.popleft()[1]
        return newest


_OWN = 67
"""Keeps its draws apart from those of sensors and gusts of the same seed."""
_ROUNDED = 1e-9
"""By which sums of periods may be off [s]."""
