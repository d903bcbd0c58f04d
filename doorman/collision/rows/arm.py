r"""The arm stays on its side of the rotors' plane: :math:`S^3_z,\ \ldots,\ S^n_z,\ d_z \le 0` (the paper's row 1).

With the arm's side s = ±1, a row is :math:`m - s z_i \le 0`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.collision.rows.kind import Kind

_NEVER = -1.0
"""Clearance row of a point that is fixed to the body, which is not in its way [m]."""


class Arm(Kind):
    """Every constrained point of the arm."""

    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """One a point."""
        return tuple(f"{point} {'above' if above else 'below'} body" for point in points)

    def excess(self, task: Any, margin: Any) -> list[Any]:
        """See `Kind`."""
        return [
            _NEVER if point in task.fixed_points else margin - task.arm_side * place[2]
            for point, place in task.points_in_body.items()
        ]
