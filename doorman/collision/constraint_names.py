"""Names of the collision constraints, for messages; without CasADi, which a model that is printed does not need."""

from __future__ import annotations

from collections.abc import Iterable


def arm_constraint_names(points: Iterable[str], above: bool) -> tuple[str, ...]:
    """Names of the arm's constraints."""
    return tuple(f"{point} {'above' if above else 'below'} body" for point in points)
