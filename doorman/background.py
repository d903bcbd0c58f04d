"""Bases of what runs beside its user: a device that `with` opens and always stops, a thread of its own, and the log of events."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from typing import Generic, Self, TypeVar

from doorman.clocks import REAL_TIME, Clock
from doorman.copying import Uncopied
from doorman.exceptions import BackendError


class Opened(Uncopied):
    """Base of what `open` opens and `stop`, which may be called twice, closes; `with` does both."""

    def open(self) -> None:
        raise NotImplementedError

    def stop(self) -> None:
        raise NotImplementedError

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


class Closed(Uncopied):
    """Base of what `close`, which may be called twice, ends; `with` does so."""

    def close(self) -> None:
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class InThread(Opened):
    """Base of what calls `_run` in a thread of its own, from `open` until `_stopping` is set."""

    _patience = 2.0
    """How long `stop` waits for the thread [s]."""

    def __init__(self, name: str, clock: Clock = REAL_TIME) -> None:
        self._name, self._clock = name, clock
        self._stopping = clock.event()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        self._require_closed()
        self._stopping.clear()
        self._begin()
        self._thread = self._clock.thread(self._run, name=self._name)
        self._thread.start()

    def stop(self) -> None:
        thread, self._thread = self._thread, None
        if thread is not None:
            self._stopping.set()
            self._interrupt()
            thread.join(self._patience)
            if thread.is_alive():
                self._stuck()
            self._end()

    @property
    def alive(self) -> bool:
        """Whether the thread runs, and was not stopped."""
        return self._thread is not None and self._thread.is_alive()

    def _require_open(self) -> None:
        if self._thread is None:
            raise BackendError(f"the {self._name} is not open", allowed="open() before anything else")

    def _require_closed(self) -> None:
        if self._thread is not None:
            raise BackendError(f"the {self._name} is open already", allowed="stop() before another open()")

    def _begin(self) -> None:
        """Open what the thread uses."""

    def _run(self) -> None:
        raise NotImplementedError

    def _interrupt(self) -> None:
        """Wake a thread that waits for something else than `_stopping`."""

    def _stuck(self) -> None:
        """The thread does not end; by default it goes on until the process ends."""

    def _end(self) -> None:
        """Close what the thread used."""


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
