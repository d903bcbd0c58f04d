"""Files of a figure: laid out once, written in every format."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # matplotlib takes a second to import
    from matplotlib.figure import Figure

FORMATS = ("png", "pdf")
_DPI = 140
"""Resolution of a figure in pixels."""


def lay_out(figure: Figure) -> None:
    """Lay a figure out once for all the files that it is written to; else every file does that again, twice."""
    engine = figure.get_layout_engine()
    if engine is not None:
        for _ in range(2):  # the ticks of an axes of fixed aspect follow its size, and the room for them its ticks
            engine.execute(figure)
        figure.set_layout_engine(None)


def save_as(figure: Figure, file: Path) -> None:
    """Write a figure in the format that the file's suffix names; its folder is made if it does not exist."""
    file.parent.mkdir(parents=True, exist_ok=True)
    drawn, form = BytesIO(), file.suffix[1:]  # matplotlib hides what a full disk says
    figure.savefig(drawn, dpi=_DPI if form == "png" else "figure", format=form)
    try:
        file.write_bytes(drawn.getvalue())
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from error
