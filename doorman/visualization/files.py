"""Files of a figure: laid out once, written in every format."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any, Protocol

FORMATS = ("png", "pdf")
_DPI = 140
"""Resolution of a figure in pixels."""


class Drawn(Protocol):
    """What is used here of matplotlib's `Figure`, which takes a second to import."""

    def get_layout_engine(self) -> Any:
        """What places its panels, if anything still does."""

    def set_layout_engine(self, layout: Any) -> None:
        """Take another layout engine."""

    def savefig(self, fname: Any, *, dpi: Any, format: str) -> None:
        """Write the figure to a file."""


def lay_out(figure: Drawn) -> None:
    """Lay a figure out once for all the files that it is written to; else every file does that again, twice."""
    engine = figure.get_layout_engine()
    if engine is not None:
        for _ in range(2):  # the ticks of an axes of fixed aspect follow its size, and the room for them its ticks
            engine.execute(figure)
        figure.set_layout_engine(None)


def save_as(figure: Drawn, file: Path) -> None:
    """Write a figure in the format that the file's suffix names; its folder is made if it does not exist."""
    file.parent.mkdir(parents=True, exist_ok=True)
    drawn, form = BytesIO(), file.suffix[1:]  # matplotlib hides what a full disk says
    figure.savefig(drawn, dpi=_DPI if form == "png" else "figure", format=form)
    try:
        file.write_bytes(drawn.getvalue())
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from error
