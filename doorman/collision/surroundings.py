"""What stands beside the door of a task, and which constraints follow from it; `constraints` has their equations."""

from __future__ import annotations

from typing import Literal

from doorman.collision.constraint_names import arm_constraint_names

Surroundings = Literal["doorway", "corners", "wall", "panel"]
"""The vehicle is between the jambs all the way; it begins beside them; it stays before the wall; or beside what slides."""

LEAF = "disc clear of leaf"
JAMBS = ("disc clear of latch jamb", "disc clear of hinge jamb")
"""Rows of a doorway, and of its corners."""
WALL = "disc clear of wall"
"""Row of a wall."""
PANEL = "disc clear of panel"
"""Row of a leaf that slides beside the vehicle."""
_ROWS: dict[Surroundings, tuple[str, ...]] = {"doorway": JAMBS, "corners": JAMBS, "wall": (WALL,), "panel": (PANEL,)}


def rows_beside(surroundings: Surroundings) -> tuple[str, ...]:
    """Names of the constraints with what stands beside the door."""
    return _ROWS[surroundings]


def row_names(point_names: tuple[str, ...], above: bool, surroundings: Surroundings) -> tuple[str, ...]:
    """Names of the collision constraints, in their order."""
    return (*arm_constraint_names(point_names, above), LEAF, *_ROWS[surroundings])
