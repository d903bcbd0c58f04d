"""Printing that cannot hold up a flight: a terminal may be stopped, slow, gone, or a file on a full disk."""

from __future__ import annotations

import contextlib
import queue
import threading
from typing import TextIO

from doorman.hardware.scheduling import give_way


class BackgroundPrinter:
    """Prints lines in a thread of its own, in their order; whatever goes wrong there stays there.

    As many lines wait for a terminal that takes none, further ones are lost; in the end, it has that patience [s].
    """

    def __init__(self, stream: TextIO, most: int = 500, patience: float = 2.0) -> None:
        self._stream, self._patience = stream, patience
        self._over = "\r" if stream.isatty() else "\n"
        self._lines: queue.Queue[str | None] = queue.Queue(most)
        self._thread = threading.Thread(target=self._run, name="printer", daemon=True)

    def __enter__(self) -> BackgroundPrinter:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._put(None)
        self._thread.join(self._patience)

    def print(self, words: str) -> None:
        """Print a line in the printer's thread."""
        self._put(f"{words}\n")

    def print_over(self, words: str) -> None:
        """Print a line in the printer's thread that the next one may replace, where the stream is a terminal."""
        self._put(words + self._over)

    def _put(self, text: str | None) -> None:
        with contextlib.suppress(queue.Full):
            self._lines.put_nowait(text)

    def _run(self) -> None:
        give_way()
        while (text := self._lines.get()) is not None:
            with contextlib.suppress(Exception):
                self._stream.write(text)
                self._stream.flush()
