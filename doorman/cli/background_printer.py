"""Printing that cannot hold up a flight: a terminal may be stopped, slow, gone, or a file on a full disk."""

from __future__ import annotations

import contextlib
import queue
import threading
from types import TracebackType

from rich.console import Console

_LONGEST = 500
"""Lines that wait for a terminal which takes none; further ones are lost."""
_PATIENCE = 2.0
"""For them at the end [s]."""


class BackgroundPrinter:
    """Prints lines in a thread of its own, in their order; whatever goes wrong there stays there.

    Args:
        console: Where to.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._lines: queue.Queue[tuple[str, str] | None] = queue.Queue(_LONGEST)
        self._thread = threading.Thread(target=self._run, name="printer", daemon=True)

    def __enter__(self) -> BackgroundPrinter:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._put(None)
        self._thread.join(_PATIENCE)

    def print(self, words: str) -> None:
        """Print a line, soon."""
        self._put((words, "\n"))

    def print_over(self, words: str) -> None:
        """Print a line that the next one may replace, where the console is a terminal."""
        self._put((words, "\r" if self._console.is_terminal else "\n"))

    def _put(self, line: tuple[str, str] | None) -> None:
        with contextlib.suppress(queue.Full):
            self._lines.put_nowait(line)

    def _run(self) -> None:
        while (line := self._lines.get()) is not None:
            with contextlib.suppress(OSError, SystemExit):  # the console exits where its reader has gone
                self._console.print(line[0], end=line[1], soft_wrap=True)
