"""What the figures share: matplotlib's objects, colours, true states, and how a figure is saved.

Matplotlib is used without windows and without global state. The colours are those of Okabe and Ito, which colour-blind readers
tell apart; lines of different meaning differ in style as well.
"""

from __future__ import annotations

import importlib
import os
from contextlib import suppress
from pathlib import Path

from doorman.recording import Recording
from doorman.visualization.files import FORMATS, lay_out, save_as


def _import_matplotlib() -> None:
    """Import it although the environment may name a backend that does not exist: figures in files need none."""
    backend = os.environ.pop("MPLBACKEND", "")
    try:
        matplotlib = importlib.import_module("matplotlib")
        if backend:
            with suppress(ValueError):
                matplotlib.rcParams["backend"] = backend
    finally:
        if backend:
            os.environ["MPLBACKEND"] = backend


_import_matplotlib()
from matplotlib import colormaps  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.patches import Circle  # noqa: E402
from matplotlib.ticker import FuncFormatter, MaxNLocator  # noqa: E402

__all__ = [
    "Axes", "Circle", "Figure", "FuncFormatter", "MaxNLocator", "colormaps", "flight_name", "not_recorded", "save", "widen",
]  # fmt: skip

BLACK, ORANGE, SKY, GREEN, BLUE, RED, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#D55E00", "#CC79A7"
)  # fmt: skip
CYCLE = (BLUE, ORANGE, GREEN, PURPLE, SKY, RED, BLACK)


def flight_name(recording: Recording) -> str:
    """Name of the scenario that was flown, with dollar signs escaped for matplotlib."""
    return str(recording.header.get("name", "flight")).replace("$", r"\$")


def not_recorded(axes: Axes) -> None:
    """Say in an empty panel that the recording lacks what it would show."""
    axes.text(0.5, 0.5, "not recorded", ha="center", va="center", transform=axes.transAxes, color="0.5")


def widen(axes: Axes, least: float = 2.0) -> None:
    """Do not blow up noise: at least so many degrees from the middle of a panel to its edge."""
    low, high = axes.get_ylim()
    middle, half = (low + high) / 2, max((high - low) / 2, least)
    axes.set_ylim(middle - half, middle + half)
    axes.grid(alpha=0.3)


def save(figure: Figure, folder: str | Path, name: str) -> tuple[Path, Path]:
    """Write a figure as PNG and PDF.

    Args:
        figure: The figure.
        folder: Where to; made if it does not exist.
        name: File name without suffix.

    Returns:
        Paths of the PNG and of the PDF.

    Raises:
        OSError: if a file cannot be written.
    """
    png, pdf = (Path(folder) / f"{name}.{suffix}" for suffix in FORMATS)
    lay_out(figure)
    save_as(figure, png)
    save_as(figure, pdf)
    return png, pdf
