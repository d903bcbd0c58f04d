"""Since when something has held without a break."""

from __future__ import annotations


def since(before: float | None, holds: bool, now: float) -> float | None:
    """Since when it has held; None if it does not."""
    if not holds:
        return None
    return now if before is None else before
