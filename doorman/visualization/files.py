"""Files of a figure: laid out once, written in every format."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any, Protocol

FORMATS = ("png", "pdf")
_DPI = 140
"""Of a figure in pixels."""


class Drawn(Protocol):
    """What is used here of matplotlib's `Figure`, which takes a second to import."""

    def get_layout_engine(self) -> Any:
        """What places its panels, if anything still does."""

    def set_layout_engine(self, layout: Any) -> None:
        """Take another layout engine.

        Args:
            layout: Matplotlib's engine or its name; None for none.
        """

    def savefig(self, fname: Any, *, dpi: Any, format: str) -> None:
        """Write the figure to a file.

        Args:
            fname: The file.
            dpi: Pixels per inch.
            format: Such as `png`.
        """


def lay_out(figure: Drawn) -> None:
    """Lay a figure out once for all the files that it is written to; else every file does that again, twice.

    Args:
        figure: That is drawn to its end.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)


def save_as(figure: Drawn, file: Path) -> None:
    """Write a figure in the format that the file's suffix names; its folder is made if it does not exist.

    Args:
        figure: To write.
        file: Where to.

    Raises:
        OSError: if the file cannot be written.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    drawn, form = BytesIO(), file.suffix[1:]  # matplotlib hides what a full disk says
    figure.savefig(drawn, dpi=_DPI if form == "png" else "figure", format=form)
    try:
        file.write_bytes(drawn.getvalue())
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from error
