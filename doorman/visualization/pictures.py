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
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from doorman.cores import usable_cores
from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.files import FORMATS, lay_out, save_as
from doorman.visualization.replay import replay_page

if TYPE_CHECKING:  # matplotlib takes a second to import
    from matplotlib.figure import Figure

Draw: TypeAlias = "Callable[[Recording, Model], Figure]"
_SHARES = 2
"""Processes that draw at a time: four figures are soon drawn."""


def _drawn_by(module: str, function: str) -> Draw:
    """A function that draws a figure, whose module, and matplotlib with it, comes when it is called."""

    def draw(recording: Recording, model: Model) -> Figure:
        drawn: Figure = getattr(importlib.import_module(f"doorman.visualization.{module}"), function)(recording, model)
        return drawn

    return draw


_DRAWN_BY = {
    "states": ("figures.states", "states_figure"),
    "constraints": ("figures.constraints", "constraints_and_forces_figure"),
    "swing": ("figures.swing", "swing_figure"),
    "planner_time": ("figures.timing", "planner_time_figure"),
}
"""Module and function of every figure."""
_FIGURES: dict[str, Draw] = {name: _drawn_by(module, function) for name, (module, function) in _DRAWN_BY.items()}


class PicturesMissing(DoormanError):
    """Some pictures of a run could not be written, such as on a full disk; the others are there."""


def import_figures() -> None:
    """Import what draws, which takes a second or two, before there is anything to draw."""
    for module, _ in _DRAWN_BY.values():
        importlib.import_module(f"doorman.visualization.{module}")
    for suffix in FORMATS:
        importlib.import_module(f"matplotlib.backends.backend_{'agg' if suffix == 'png' else suffix}")


class Drawing(NamedTuple):
    """What came of some figures."""

    figures: list[str]  # their names
    missing: dict[str, str]  # names of files that could not be written, and why


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
        helper.begin(list(_FIGURES), folder / "recording.mcap", folder)
    page = Drawing([], {})
    _write(partial(replay_page, recording, model), folder / "replay.html", page.missing)
    drawn = [page, *(helper.answers() if helper is not None else [])]
    done = {name for one in drawn for name in one.figures}
    drawn.append(draw_figures([name for name in _FIGURES if name not in done], recording, model, folder))
    missing = {name: reason for one in drawn for name, reason in one.missing.items()}
    if missing:
        names = [name for name in _file_names() if name in missing]
        reasons = ", ".join(dict.fromkeys(missing[name] for name in names))
        raise PicturesMissing(f"missing: {', '.join(names)}: {reasons}", file=folder)
    return [folder / name for name in _file_names()]


def draw_figures(names: Sequence[str], recording: Recording, model: Model, folder: Path) -> Drawing:
    """Draw some of the figures."""
    drawn = Drawing(list(names), {})
    for name in names:
        figure = _FIGURES[name](recording, model)
        lay_out(figure)
        for suffix in FORMATS:
            _write(partial(save_as, figure), folder / f"{name}.{suffix}", drawn.missing)
    return drawn


def _file_names() -> list[str]:
    return [*(f"{name}.{suffix}" for name in _FIGURES for suffix in FORMATS), "replay.html"]


def _write(write: Callable[[Path], object], file: Path, missing: dict[str, str]) -> None:
    try:
        write(file)
    except OSError as error:
        missing[file.name] = error.strerror or str(error)
        with suppress(OSError):
            file.unlink()


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
