"""Phases of a mission, as bands behind the curves of a figure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.recording import Recording
from doorman.visualization.style import Axes

TIED = ("touch", "open", "hold", "recover", "take_back")
"""Phases in which the tip is at the door."""


def phases(recording: Recording, end: float) -> list[tuple[str, float, float]]:
    if "mission" not in recording:
        return []
    mission = recording["mission"]
    begun = zip(mission["state"].tolist(), mission.time.tolist(), strict=True)
    named = [(name, time) for name, time in begun if name != "end"]
    ends = [*(time for _, time in named[1:]), end]
    return [(name, start, stop) for (name, start), stop in zip(named, ends, strict=True) if stop > start]


def tied(recording: Recording, time: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the tip is at the door, by the mission's phases; always where it has none."""
    known = phases(recording, np.inf)
    if not known:
        return np.ones(len(time), dtype=bool)
    there = np.zeros(len(time), dtype=bool)
    for name, start, stop in known:
        if name in TIED:
            there |= (time >= start) & (time <= stop)
    return there


def draw_phases(
    axes: Axes, recording: Recording, span: tuple[float, float], *, named: bool, least_share: float = 0.035
) -> None:
    """Shade the phases of a mission by turns, and write the names above that have a least share of the time axis."""
    known = phases(recording, span[1])
    for k, (name, start, stop) in enumerate(known):
        if len(known) > 1:
            axes.axvspan(start, stop, facecolor=("0.93", "1.0")[k % 2], edgecolor="none", zorder=0)
        if named and stop - start > least_share * (span[1] - span[0]):
            middle = 0.5 * (start + stop)
            axes.text(middle, 1.02, name, rotation=35, fontsize=7, color="0.35", ha="left", va="bottom",
                      transform=axes.get_xaxis_transform())  # fmt: skip
