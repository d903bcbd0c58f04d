"""Picture process: draws a run's figures beside whoever flies, and imports what draws while the run is still flown.

It is forked from a process that has the model already. Where forking is not safe, or there is a single core, nobody helps.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.pictures import Drawing, draw_figures, import_figures

_SHARES = 2
"""Processes that draw at a time: four figures are soon drawn."""


class PictureProcess:
    def __init__(self, model: Model) -> None:
        self._answers, theirs = multiprocessing.Pipe()
        with warnings.catch_warnings():  # of threads: those of libraries, which know how to be forked
            warnings.simplefilter("ignore", DeprecationWarning)
            context = multiprocessing.get_context("fork")
            self._process = context.Process(target=_serve, args=(model, theirs, self._answers), daemon=False)
            self._process.start()
        theirs.close()

    def begin(self, figures: Sequence[str], recording: Path, folder: Path) -> None:
        with suppress(OSError):  # one that has died gives no answer either
            self._answers.send((list(figures), recording, folder))

    def answers(self) -> list[Drawing]:
        """What was drawn, once all is; figures that are in none of the answers were not drawn."""
        found: list[Drawing] = []
        with suppress(EOFError, OSError):
            while True:
                found.append(self._answers.recv())
        return found

    def close(self) -> None:
        self._process.kill()
        self._process.join()
        self._answers.close()


@contextmanager
def picture_process(model: Model) -> Iterator[PictureProcess | None]:
    """A process that gets ready to draw; None where whoever waits had better draw."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    process = None
    if sys.platform == "linux" and cores > 1:  # elsewhere system libraries do not survive a fork
        with suppress(OSError):
            process = PictureProcess(model)
    try:
        yield process
    finally:
        if process is not None:
            process.close()


def _serve(model: Model, connection: Connection, other_end: Connection) -> None:
    """Get ready, wait for an order, and draw it, two shares at a time."""
    other_end.close()  # so that the end of whoever ordered is noticed
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the flight, and what was flown is drawn
    import_figures()
    try:
        figures, file, folder = connection.recv()
    except EOFError:
        return
    recording = Recording.load(file)
    shares = [figures[index::_SHARES] for index in range(_SHARES)]
    context = multiprocessing.get_context("fork")
    others = [context.Process(target=_draw, args=(share, recording, model, folder, connection)) for share in shares[1:]]
    for other in others:
        other.start()
    _draw(shares[0], recording, model, folder, connection)
    for other in others:
        other.join()


def _draw(figures: list[str], recording: Recording, model: Model, folder: Path, connection: Connection) -> None:
    for name in figures:
        connection.send(draw_figures([name], recording, model, folder))
