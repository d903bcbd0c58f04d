r"""The rotor disc stays between the jambs, wherever the vehicle is (the paper's row 3).

:math:`a^T(P - P_h) - D_w + r_a \le 0` and :math:`r_a - a^T(P - P_h) \le 0` with the direction a of the closed leaf, the
paper's y, and what the disc takes up along it: :math:`r_a = R_A` in the paper, which takes it for level. The paper prints
:math:`+ D_w` in the lower bound; it follows from :math:`P_y - P_{hy} \le D_w - R_A` that it is −.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.kind import Kind

JAMBS = ("disc clear of latch jamb", "disc clear of hinge jamb")


class Jambs(Kind):
    """Disc and jambs of a doorway that the vehicle flies in all the way."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One a jamb."""
        return JAMBS

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        across, half = task.across_doorway, task.half_width
        return [across - task.door.width + half + margin, half - across + margin]
