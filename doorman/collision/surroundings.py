"""What stands beside the door of a task, and which constraints follow from it; `constraints` has their equations."""

from __future__ import annotations

from typing import Literal

Surroundings = Literal["doorway", "corners", "wall"]
"""The vehicle is between the jambs all the way; it begins beside them; or it stays before the wall."""

LEAF = "disc clear of leaf"
JAMBS = ("disc clear of latch jamb", "disc clear of hinge jamb")
"""Rows of a doorway, and of its corners."""
WALL = "disc clear of wall"
"""Row of a wall."""
_ROWS: dict[Surroundings, tuple[str, ...]] = {"doorway": JAMBS, "corners": JAMBS, "wall": (WALL,)}


def row_names(point_names: tuple[str, ...], surroundings: Surroundings) -> tuple[str, ...]:
    """Names of the collision constraints, in their order.

    Args:
        point_names: Of the arm's points.
        surroundings: What stands beside the door.
    """
    return (*(f"{name} below body" for name in point_names), LEAF, *_ROWS[surroundings])
