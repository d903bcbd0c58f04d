"""All pictures of a run in its folder, the same after a flight and from a recording, and a process that draws them beside it."""

from __future__ import annotations

import importlib
import multiprocessing
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from doorman.cores import usable_cores
from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.files import FORMATS, lay_out, save_as
from doorman.visualization.replay import replay_page

if TYPE_CHECKING:  # matplotlib takes a second to import
    from matplotlib.figure import Figure

_SHARES = 2
"""Processes that draw at a time: four figures are soon drawn."""
_FIGURES = {
    "states": ("figures.states", "states_figure"),
    "constraints": ("figures.constraints", "constraints_and_forces_figure"),
    "swing": ("figures.swing", "swing_figure"),
    "planner_time": ("figures.timing", "planner_time_figure"),
}
"""Module and function of every figure."""


class PicturesMissing(DoormanError):
    """Some pictures of a run could not be written, such as on a full disk; the others are there."""


class PictureProcess:
    """Draws figures beside the flight; forked from a process that has the model, and imports what draws meanwhile."""

    def __init__(self, model: Model) -> None:
        self._answers, theirs = multiprocessing.Pipe()
        with warnings.catch_warnings():  # of threads: those of libraries, which know how to be forked
            warnings.simplefilter("ignore", DeprecationWarning)
            context = multiprocessing.get_context("fork")
            self._process = context.Process(target=_serve, args=(model, theirs, self._answers), daemon=False)
            self._process.start()
        theirs.close()

    def begin(self, recording: Path, folder: Path) -> None:
        with suppress(OSError):  # one that has died gives no answer either
            self._answers.send((recording, folder))

    def answers(self) -> dict[str, dict[str, str]]:
        """Figures that were drawn, once all are: names of their files that could not be written, and why."""
        found: dict[str, dict[str, str]] = {}
        with suppress(EOFError, OSError):
            while True:
                found |= self._answers.recv()
        return found

    def close(self) -> None:
        self._process.kill()
        self._process.join()
        self._answers.close()


def write_pictures(
    recording: Recording, model: Model, folder: Path, helper: PictureProcess | None = None
) -> list[Path]:
    """Draw the figures and the replay page of a run.

    A file that cannot be written does not keep the others from being written, and is not left there in part.

    Args:
        recording: The run.
        model: Model of the scenario that was flown.
        folder: Where to write.
        helper: Draws the figures meanwhile, from `recording.mcap` in the folder; what it does not draw is drawn here.

    Returns:
        The files.

    Raises:
        RecordingError: if the recording lacks what a figure shows.
        PicturesMissing: if a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if helper is not None:
        helper.begin(folder / "recording.mcap", folder)
    missing = _write(partial(replay_page, recording, model), folder / "replay.html")
    there = {} if helper is None else helper.answers()
    for name in _FIGURES:
        missing |= there[name] if name in there else _draw(name, recording, model, folder)
    names = [*(f"{name}.{suffix}" for name in _FIGURES for suffix in FORMATS), "replay.html"]
    if missing:
        lost = [name for name in names if name in missing]
        reasons = ", ".join(dict.fromkeys(missing[name] for name in lost))
        raise PicturesMissing(f"missing: {', '.join(lost)}: {reasons}", file=folder)
    return [folder / name for name in names]


def figure_of(name: str, recording: Recording, model: Model) -> Figure:
    """A figure; its module, and matplotlib with it, comes when it is drawn first."""
    module, function = _FIGURES[name]
    figure: Figure = getattr(importlib.import_module(f"doorman.visualization.{module}"), function)(recording, model)
    return figure


def _draw(name: str, recording: Recording, model: Model, folder: Path) -> dict[str, str]:
    """Write a figure in every format; names of files that could not be written, and why."""
    figure = figure_of(name, recording, model)
    missing: dict[str, str] = {}
    lay_out(figure)
    for suffix in FORMATS:
        missing |= _write(partial(save_as, figure), folder / f"{name}.{suffix}")
    return missing


def _write(write: Callable[[Path], object], file: Path) -> dict[str, str]:
    try:
        write(file)
    except OSError as error:
        with suppress(OSError):
            file.unlink()
        return {file.name: error.strerror or str(error)}
    return {}


@contextmanager
def picture_process(model: Model) -> Iterator[PictureProcess | None]:
    """A process that gets ready to draw; None where whoever waits had better draw."""
    process = None
    if sys.platform == "linux" and usable_cores() > 1:  # elsewhere system libraries do not survive a fork
        with suppress(OSError):
            process = PictureProcess(model)
    try:
        yield process
    finally:
        if process is not None:
            process.close()


def _serve(model: Model, connection: Connection, other_end: Connection) -> None:
    """Import what draws, which takes a second or two, wait for an order, and draw it, two shares at a time."""
    other_end.close()  # so that the end of whoever ordered is noticed
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the flight, and what was flown is drawn
    for module, _ in _FIGURES.values():
        importlib.import_module(f"doorman.visualization.{module}")
    for suffix in FORMATS:
        importlib.import_module(f"matplotlib.backends.backend_{'agg' if suffix == 'png' else suffix}")
    try:
        file, folder = connection.recv()
    except EOFError:
        return
    recording = Recording.load(file)

    def draw(names: Sequence[str]) -> None:
        for name in names:
            connection.send({name: _draw(name, recording, model, folder)})

    own, *shares = (list(_FIGURES)[index::_SHARES] for index in range(_SHARES))
    others = [multiprocessing.get_context("fork").Process(target=draw, args=(share,)) for share in shares]
    for other in others:
        other.start()
    draw(own)
    for other in others:
        other.join()
