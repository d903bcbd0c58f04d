r"""A lintel counts near the wall alone: disc and arm are below it, or outside of the wall: :math:`\min(b, o) \le 0`.

b is the row of `lintel`, the disc's for an arm below the body. With the direction i through the doorway, the wall's faces at
:math:`-b_f` and :math:`b_b`, and the place p of the disc's centre or of a point of the arm,

.. math:: o = r + \tfrac12(b_f + b_b) - \lvert i^T(p - P_h) - \tfrac12(b_b - b_f)\rvert

with :math:`r = R_A\sqrt{1 - (i^T R e_3)^2}` of the disc, and 0 of a point. The smaller of the two is rounded from above, the
magnitude from below: where a row holds, so does one of the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.corners import ROUNDING
from doorman.collision.rows.kind import Kind, disc_across, dot
from doorman.collision.rows.lintel import LINTEL, Lintel, turned_points


class LintelEdge(Kind):
    """Disc, arm, and the lintel of a doorway that the task begins before or beside."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One of the disc; one a point of the arm."""
        return (LINTEL, *(f"{point} clear of lintel" for point in points))

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        into, door, points = task.leaf.into_in_heading, task.door, turned_points(task)
        half, middle = 0.5 * (door.frame_depth + door.frame_back), 0.5 * (door.frame_back - door.frame_depth)
        below = Lintel().excess(task, margin)
        below += below * len(points) if len(below) == 1 else []
        reaches = [(disc_across(task, into), 0.0), *((0.0, dot(into, place)) for place in points)]
        return [
            _smaller(row, wide + half + margin - _size(task.into_doorway + ahead - middle))
            for row, (wide, ahead) in zip(below, reaches, strict=True)
        ]


def _smaller(a: Any, b: Any) -> Any:
    """min(a, b), rounded from above."""
    return 0.5 * (a + b - ((a - b) ** 2 + ROUNDING**2) ** 0.5 + ROUNDING)


def _size(value: Any) -> Any:
    """|·|, rounded from below."""
    return (value**2 + ROUNDING**2) ** 0.5 - ROUNDING
