"""What the figures share: matplotlib's objects, colours, true states, and how a figure is saved.

Matplotlib is used without windows and without global state. The colours are those of Okabe and Ito, which colour-blind readers
tell apart; lines of different meaning differ in style as well.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import DoormanError, how_to_install
from doorman.recording import Recording

try:
    from matplotlib import colormaps
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle
    from matplotlib.ticker import FuncFormatter
except ImportError as error:
    raise DoormanError("figures need matplotlib", field="matplotlib", allowed=how_to_install("viz")) from error

__all__ = ["Axes", "Circle", "Figure", "FuncFormatter", "colormaps", "flight_name", "save", "true_states"]

Array = NDArray[np.float64]

BLACK, ORANGE, SKY, GREEN, BLUE, RED, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#D55E00", "#CC79A7"
)  # fmt: skip
CYCLE = (BLUE, ORANGE, GREEN, PURPLE, SKY, RED, BLACK)


def flight_name(recording: Recording) -> str:
    """Name of the scenario that was flown."""
    return str(recording.header.get("name", "flight"))


def true_states(recording: Recording) -> tuple[Array, Array] | None:
    """Times (m,) and states x (m, 5 + n) of the simulator; None if there was none."""
    if "truth" not in recording:
        return None
    truth = recording["truth"]
    return truth.time, np.column_stack(
        [truth["attitude"], truth["door_angle"], truth["door_rate"], truth["arm_angles"]]
    )


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
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    png, pdf = folder / f"{name}.png", folder / f"{name}.pdf"
    figure.savefig(png, dpi=140)
    figure.savefig(pdf)
    return png, pdf
