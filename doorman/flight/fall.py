"""Tells a landing from a fall: by the speed shortly before the motors are seen to have stopped."""

from __future__ import annotations

from collections import deque

FALLING = 2.0
"""No vehicle lands so fast: it has fallen by 0.2 m then [m/s]."""
_REMEMBERED = 2.0
"""Motors that stopped are told of by a heartbeat, once a second; a fall from 1.3 m takes half of that [s]."""


class FallWatch:
    """Speeds of a vehicle that is, or was, in the air."""

    def __init__(self) -> None:
        self._speeds: deque[tuple[float, float]] = deque()
        self._disarmed_at: float | None = None

    def note(self, now: float, speed: float, armed: bool) -> None:
        """Take in a look.

        Args:
            now: [s].
            speed: NaN where nobody knows it [m/s].
            armed: Whether the motors run.
        """
        if armed:
            self._disarmed_at = None
        elif self._disarmed_at is None:
            self._disarmed_at = now
        self._speeds.append((now, speed))
        since = (now if self._disarmed_at is None else self._disarmed_at) - _REMEMBERED
        while self._speeds[0][0] < since:
            self._speeds.popleft()

    @property
    def fell(self) -> bool:
        """Whether it was falling when its motors had stopped, or shortly before that was seen."""
        return self._disarmed_at is not None and any(speed > FALLING for _, speed in self._speeds)
