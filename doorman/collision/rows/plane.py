r"""The rotor disc, wherever it tilts, stays on its side of a plane: of the leaf (the paper's row 2), a wall or a panel.

.. math:: R_A\sqrt{1 - (n^T R e_3)^2} - b \le 0

n is the plane's normal, b the distance of :math:`O_B` from it. Of the leaf, :math:`b = n_D^T(p - P)` with the contact point
p. With the tip there, and :math:`n = R^T n_D`, the row is :math:`R_A\sqrt{n_x^2+n_y^2} - n^T d \le 0`. A vehicle that pulls
stays before the wall, :math:`b = -i^T(P - P_h) - b_f`, with i through the doorway and the depth :math:`b_f` of the frame. One
that moves a slide by a handle stays on the handle's side of the panel that slides, :math:`b = p^T(P - P_h) - c`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from doorman.collision.rows.kind import Kind, disc_across

LEAF, WALL, PANEL = "disc clear of leaf", "disc clear of wall", "disc clear of panel"


class Plane(Kind):
    """Disc and a plane: its normal in the frame of `tilt_rotation`, and the distance of O_B from it, of a task."""

    def __init__(self, name: str, normal: Callable[[Any], Any], distance: Callable[[Any], Any]) -> None:
        self._name, self._normal, self._distance = name, normal, distance

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One."""
        return (self._name,)

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        return [disc_across(task, self._normal(task)) - self._distance(task) + margin]


PLANES: dict[str, Kind] = {
    "leaf": Plane(LEAF, lambda task: task.leaf.normal_in_heading, lambda task: task.before_leaf),
    "wall": Plane(
        WALL, lambda task: task.leaf.into_in_heading, lambda task: -task.into_doorway - task.door.frame_depth
    ),
    "panel": Plane(PANEL, lambda task: task.leaf.in_heading(task.door.panel), lambda task: task.before_panel),
}
