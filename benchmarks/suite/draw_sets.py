"""Sets of draws on which ways to plan a push are compared: campaigns, and how many of their runs count."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

_FOLDER = Path(__file__).parents[1] / "draws"


@dataclass(frozen=True)
class DrawSet:
    """One campaign."""

    source: str
    """Name of a shipped scenario, or path of one."""
    runs: int
    """The first so many of its runs."""
    words: str
    """What is drawn, for the table."""


def _beside(name: str, runs: int, words: str) -> DrawSet:
    return DrawSet(str(_FOLDER / f"{name}.toml"), runs, words)


SETS = {
    "push_campaign": DrawSet("push_campaign", 100, "`push_campaign`"),
    "mirrored": _beside("mirrored", 60, "`push_campaign` with the hinge on the left"),
    "turning_wind_slow": _beside("turning_wind_slow", 20, "wind of 1 N turns by 4.5°/s"),
    "turning_wind_fast": _beside("turning_wind_fast", 20, "wind of 1 N turns by 9°/s"),
    "late_cameras": _beside("late_cameras", 20, "cameras 100 Hz, 40 ms late"),
    "proud_face": _beside("proud_face", 20, "face 40 mm before the axis"),
    "misplaced_door": _beside("misplaced_door", 20, "door up to 2 cm, 2° elsewhere"),
    "closers": _beside("closers", 20, "closers up to 2 N m/rad"),
    "narrow_doorways": _beside("narrow_doorways", 20, "doorways of 1.10 to 1.14 m"),
    "small_doors": _beside("small_doors", 60, "small hexarotor, doors of 0.76 to 0.91 m"),
    "hands": _beside("hands", 10, "a hand holds or shoves"),
}
"""By name, in the order of the table."""


def rows_of(rows: list[dict[str, Any]], runs: int) -> list[dict[str, Any]]:
    """The first runs among a campaign's rows.

    Args:
        rows: In the order of their runs.
        runs: How many count.
    """
    return [row for row in rows if row["run"] < runs]
