"""All pictures of a run in its folder: the same after a flight and from a recording."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TypeAlias

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


_FIGURES: dict[str, Draw] = {
    "states": _drawn_by("figures", "states_figure"),
    "constraints": _drawn_by("constraint_figure", "constraints_and_forces_figure"),
    "swing": _drawn_by("swing_figure", "swing_figure"),
    "planner_time": _drawn_by("timing_figure", "planner_time_figure"),
}


class PicturesMissing(DoormanError):
    """Some pictures of a run could not be written, such as on a full disk; the others are there."""


def write_pictures(recording: Recording, model: Model, folder: Path) -> list[Path]:
    """Draw the figures and the replay page of a run.

    A file that cannot be written does not keep the others from being written, and is not left there in part.

    Args:
        recording: The run.
        model: Model of the scenario that was flown.
        folder: Where to write.

    Returns:
        The files.

    Raises:
        RecordingError: if the recording lacks what a figure shows.
        PicturesMissing: if a file cannot be written.
    """
    written: list[Path] = []
    missing: dict[str, OSError] = {}
    for name, draw in _FIGURES.items():
        figure = draw(recording, model)
        lay_out(figure)
        for suffix in FORMATS:
            _write(partial(save_as, figure), folder / f"{name}.{suffix}", written, missing)
    _write(partial(replay_page, recording, model), folder / "replay.html", written, missing)
    if missing:
        reasons = ", ".join(dict.fromkeys(error.strerror or str(error) for error in missing.values()))
        raise PicturesMissing(f"missing: {', '.join(missing)}: {reasons}", file=folder)
    return written


def _write(write: Callable[[Path], object], file: Path, written: list[Path], missing: dict[str, OSError]) -> None:
    try:
        write(file)
        written.append(file)
    except OSError as error:
        missing[file.name] = error
        with suppress(OSError):
            file.unlink()
