"""All pictures of a run in its folder: the same after a flight and from a recording."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple, Protocol, TypeAlias

from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.files import FORMATS, Drawn, lay_out, save_as
from doorman.visualization.replay import replay_page

Draw: TypeAlias = Callable[[Recording, Model], Drawn]


def _drawn_by(module: str, function: str) -> Draw:
    """A function that draws a figure, whose module, and matplotlib with it, comes when it is called."""

    def draw(recording: Recording, model: Model) -> Drawn:
        drawn: Drawn = getattr(importlib.import_module(f"doorman.visualization.{module}"), function)(recording, model)
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


class Helper(Protocol):
    """Draws figures beside whoever asks."""

    def begin(self, figures: Sequence[str], recording: Path, folder: Path) -> None:
        """Order figures of a recording, drawn beside whoever asks."""

    def answers(self) -> list[Drawing]:
        """What was drawn, once all is."""


def write_pictures(recording: Recording, model: Model, folder: Path, helper: Helper | None = None) -> list[Path]:
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
