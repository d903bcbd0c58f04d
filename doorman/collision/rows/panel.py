r"""A vehicle that moves a slide by a handle stays on the handle's side of it.

:math:`R_A\sqrt{1 - (p^T R e_3)^2} - (p^T(P - P_h) - c) \le 0` with the normal p of the panel's plane, and its distance c.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.kind import Kind, disc_across

PANEL = "disc clear of panel"


class Panel(Kind):
    """Disc and a panel that slides."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One."""
        return (PANEL,)

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        return [disc_across(task, task.leaf.in_heading(task.door.panel)) - task.before_panel + margin]
