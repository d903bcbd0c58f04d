r"""The rotor disc, wherever it tilts, stays on its side of the leaf's plane (the paper's row 2).

.. math:: R_A\sqrt{1 - (n_D^T R e_3)^2} - n_D^T(p - P) \le 0

p is the contact point; :math:`n_D^T(p - P)` is the distance of :math:`O_B` from the face. With :math:`n = R^T n_D` and the tip on
the contact point that is :math:`R_A\sqrt{n_x^2+n_y^2} - n^T d \le 0`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.kind import Kind, disc_across

LEAF = "disc clear of leaf"


class Leaf(Kind):
    """Disc and leaf."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One."""
        return (LEAF,)

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        return [disc_across(task, task.leaf.normal_in_heading) - task.before_leaf + margin]
