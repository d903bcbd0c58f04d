"""Bases of what runs beside its user: a device that `with` opens and always stops, and a thread of its own."""

from __future__ import annotations

import threading
from typing import Self

from doorman.clocks import REAL_TIME, Clock
from doorman.copying import Uncopied
from doorman.exceptions import BackendError

JOIN_TIMEOUT = 2.0
"""How long `stop` waits for a thread, which ends with the process all the same [s]."""


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


class Started(Uncopied):
    """Base of what `start` starts and `stop`, which may be called twice, ends; `with` does both."""

    def start(self) -> None:
        raise NotImplementedError

    def stop(self) -> None:
        raise NotImplementedError

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


class InThread(Started):
    """Base of what calls `_run` in a thread of its own, from `start` until `_stopping` is set."""

    def __init__(self, name: str, clock: Clock = REAL_TIME) -> None:
        self._name, self._clock = name, clock
        self._stopping = clock.event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        if self._thread is not None:
            raise BackendError(f"the {self._name} runs already", allowed="stop() before another start()")
        self._stopping.clear()
        self._begin()
        self._thread = self._clock.thread(self._run, name=self._name)
        self._thread.start()

    def stop(self) -> None:
        thread, self._thread = self._thread, None
        if thread is not None:
            self._stopping.set()
            self._interrupt()
            thread.join(JOIN_TIMEOUT)
            self._end()

    def _begin(self) -> None:
        """Open what the thread uses."""

    def _run(self) -> None:
        raise NotImplementedError

    def _interrupt(self) -> None:
        """Wake a thread that waits for something else than `_stopping`."""

    def _end(self) -> None:
        """Close what the thread used."""
