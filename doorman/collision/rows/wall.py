r"""A vehicle that pulls stays before the wall: :math:`R_A\sqrt{1 - (i^T R e_3)^2} + i^T(P - P_h) + b_f \le 0`.

i is the direction through the doorway, :math:`b_f` the depth of the frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.kind import Kind, disc_across

WALL = "disc clear of wall"


class Wall(Kind):
    """Disc and wall."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One."""
        return (WALL,)

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        return [disc_across(task, task.leaf.into_in_heading) + task.into_doorway + task.door.frame_depth + margin]
