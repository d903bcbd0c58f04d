r"""A jamb counts near the wall alone: :math:`R_A - \sqrt{\max(b, 0)^2 + \max(a, 0)^2} \le 0`.

b is the distance from O_B to the plane of the wall's nearer face, a that to the jamb's edge along the wall; inside, either is 0.
Between the wall's faces, these are the rows of `jambs` for a level disc.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.jambs import JAMBS
from doorman.collision.rows.kind import LEAST_EXTENT, Kind

ROUNDING = 0.005
"""Rounding of max(0, ·) and similar functions at a corner [m]."""


class Corners(Kind):
    """Disc and the jambs' edges before, in and behind the doorway."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One a jamb."""
        return JAMBS

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        across, into, door = task.across_doorway, task.into_doorway, task.door
        half, middle = 0.5 * (door.frame_depth + door.frame_back), 0.5 * (door.frame_back - door.frame_depth)
        before = _positive(((into - middle) ** 2 + ROUNDING**2) ** 0.5 - ROUNDING - half)
        return [
            task.vehicle.radius + margin - (before**2 + _positive(beside) ** 2 + LEAST_EXTENT**2) ** 0.5
            for beside in (door.width - across, across)
        ]


def _positive(value: Any) -> Any:
    """max(0, ·), rounded from below."""
    return 0.5 * (value + (value**2 + ROUNDING**2) ** 0.5 - ROUNDING)
