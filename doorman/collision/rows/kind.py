"""A kind of collision constraint. Its arithmetic serves CasADi's symbols and numpy's numbers alike, and imports neither."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

LEAST_EXTENT = 1e-12
"""Under the root: a disc parallel to a plane has a slope, too."""


class Kind(ABC):
    """Rows that belong together. `listed` registers every kind under a short name, and says where it applies."""

    @abstractmethod
    def names(self, points: Sequence[str], above: bool) -> tuple[str, ...]:
        """Name of every row, given the arm's points and whether the arm is above the body."""

    @abstractmethod
    def excess(self, task: Any, margin: Any) -> list[Any]:
        """Value of every row, positive where it is violated [m]."""


def dot(a: Any, b: Any) -> Any:
    """Scalar product of two vectors, or of many, shapes (3,) or (3, m)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def disc_across(task: Any, direction: Any) -> Any:
    r"""Half of what the rotor disc takes up along a direction of the leaf's frame, :math:`R_A\sqrt{1 - (n^T R e_3)^2}` [m]."""
    return task.vehicle.radius * (1 - dot(direction, task.tilt_rotation[:, 2]) ** 2 + LEAST_EXTENT) ** 0.5
