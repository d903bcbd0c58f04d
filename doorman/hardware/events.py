"""The log of a device's events: its thread writes, its user takes."""

from __future__ import annotations

import contextlib
from collections import deque
from typing import Generic, TypeVar

Event = TypeVar("Event")


class EventLog(Generic[Event]):
    """The newest events; who is late finds the oldest gone."""

    def __init__(self, size: int = 4096) -> None:
        self._events: deque[Event] = deque(maxlen=size)

    def write(self, event: Event) -> None:
        self._events.append(event)

    def take(self) -> list[Event]:
        taken: list[Event] = []
        with contextlib.suppress(IndexError):  # no more of them
            while True:
                taken.append(self._events.popleft())
        return taken
