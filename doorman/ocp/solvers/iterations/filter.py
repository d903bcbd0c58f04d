"""The filter of a line search: pairs of infeasibility and cost that a search has left behind (Fletcher and Leyffer 2002)."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel

FILTER_SIZE = 64
"""Pairs that are remembered."""
MARGIN = 1e-5
"""Share of the infeasibility by which a step has to lower it to count as progress."""

_ROUNDING = 1e-11
"""Rounding of a sum of defects and violations [their units]."""


@kernel
def is_new(pairs: Array, count: int, infeasibility: float, cost: float, price: float, noise: float) -> bool:
    """Whether a pair is better than every pair of the filter: less infeasible, or cheaper by `price` times the infeasibility.

    Within the noise of rounding the same pair may come again.
    """
    if not (abs(infeasibility) < np.inf and abs(cost) < np.inf):
        return False
    for i in range(count):
        before, cost_before = pairs[i, 0], pairs[i, 1]
        if infeasibility > (1.0 - MARGIN) * before and cost > cost_before - price * before:
            if infeasibility > before + _ROUNDING or cost > cost_before + noise:
                return False
    return True


@kernel
def remember(pairs: Array, count: int, infeasibility: float, cost: float) -> int:
    """Add a pair; the oldest one is dropped where the filter is full. Returns how many there are."""
    if count == pairs.shape[0]:
        for i in range(count - 1):
            pairs[i, 0], pairs[i, 1] = pairs[i + 1, 0], pairs[i + 1, 1]
        count -= 1
    pairs[count, 0], pairs[count, 1] = infeasibility, cost
    return count + 1
