"""Tells a landing from a fall: by the speed shortly before the motors are seen to have stopped."""

from __future__ import annotations

import math
from collections import deque

FALLING = 2.0
"""No vehicle lands so fast: it has fallen by 0.2 m then [m/s]."""
_REMEMBERED = 2.0
"""A heartbeat, once a second, reports motors that stopped; a fall from 1.3 m takes half of that [s]."""


class FallWatch:
    """Speeds of a vehicle that is, or was, in the air; noted by one thread, and read by another."""

    def __init__(self) -> None:
        self._speeds: deque[tuple[float, float]] = deque()
        self._flown = self._armed = False
        self._flew_at = -math.inf

    def note(self, now: float, speed: float, armed: bool, heard: bool = True) -> None:
        """Take in a look."""
        self._armed, self._flown = armed, self._flown or armed
        if (armed and heard) or not self._flown:
            self._flew_at = now
        self._speeds.append((now, speed))
        while self._speeds[0][0] < self._flew_at - _REMEMBERED:
            self._speeds.popleft()

    @property
    def fell(self) -> bool:
        """Whether it fell when its motors had stopped, or shortly before that was heard."""
        return self._flown and not self._armed and any(speed > FALLING for _, speed in tuple(self._speeds))
