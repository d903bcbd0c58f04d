"""Since when something has held without a break."""

from __future__ import annotations


def since(before: float | None, holds: bool, now: float) -> float | None:
    """Since when it has held; None if it does not.

    Args:
        before: Since when it held until now [s].
        holds: Whether it holds now.
        now: [s].
    """
    if not holds:
        return None
    return now if before is None else before
