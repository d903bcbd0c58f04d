"""All pictures of a run in its folder: the same after a flight and from a recording."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.constraint_figure import constraints_and_forces_figure
from doorman.visualization.figures import states_figure
from doorman.visualization.replay import replay_page
from doorman.visualization.style import FORMATS, Figure, save_as
from doorman.visualization.swing_figure import swing_figure
from doorman.visualization.timing_figure import planner_time_figure

_FIGURES: dict[str, Callable[[Recording, Model], Figure]] = {
    "states": states_figure,
    "constraints": constraints_and_forces_figure,
    "swing": swing_figure,
    "planner_time": planner_time_figure,
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
