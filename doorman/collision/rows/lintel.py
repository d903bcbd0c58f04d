r"""Disc and arm stay below the lintel.

.. math:: u^T(P - P_h) + R_A\sqrt{1 - (u^T R e_3)^2} - h \le 0

u is the direction up the hinge, h the height of the opening above the leaf's lower edge. An arm below the body is lower than the
disc; of one above it, every constrained point has a row with its own height.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.kind import Kind, disc_across, dot

LINTEL = "disc below lintel"


class Lintel(Kind):
    """Disc, the arm where it is above the body, and lintel."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One of the disc; one a point of an arm above."""
        return (LINTEL, *(f"{point} below lintel" for point in points if above))

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        up = task.leaf.up
        room = task.door.frame_height - margin - dot(up, task.position_from_hinge)
        points = turned_points(task) if task.arm_side > 0 else ()
        return [disc_across(task, up) - room, *(dot(up, place) - room for place in points)]


def turned_points(task: Any) -> list[list[Any]]:
    """Places of the arm's points from O_B, in the frame of `tilt_rotation`."""
    return [[dot(task.tilt_rotation[i, :], place) for i in range(3)] for place in task.points_in_body.values()]
