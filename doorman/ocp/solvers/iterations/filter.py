"""The filter of a line search: pairs of infeasibility and cost that a search has left behind (Fletcher and Leyffer 2002)."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.records import Record

MARGIN = 1e-5
"""Share of the infeasibility by which a step has to lower it to count as progress."""

_ROUNDING = 1e-11
"""Rounding of a sum of defects and violations [their units]."""


class Filter(Record):
    """Pairs that are remembered, the oldest one first."""

    count: int
    infeasibilities: Annotated[Array, 64]
    costs: Annotated[Array, 64]


@kernel
def is_new(pairs: Filter, infeasibility: float, cost: float, price: float, noise: float) -> bool:
    """Whether a pair is better than every pair of the filter: less infeasible, or cheaper by `price` times the infeasibility.

    Within the noise of rounding the same pair may come again.
    """
    if not (abs(infeasibility) < np.inf and abs(cost) < np.inf):
        return False
    for i in range(pairs.count):
        before, cost_before = pairs.infeasibilities[i], pairs.costs[i]
        if infeasibility > (1.0 - MARGIN) * before and cost > cost_before - price * before:
            if infeasibility > before + _ROUNDING or cost > cost_before + noise:
                return False
    return True


@kernel
def remember(pairs: Filter, infeasibility: float, cost: float) -> None:
    """Add a pair; the oldest one is dropped where the filter is full."""
    infeasibilities, costs = pairs.infeasibilities, pairs.costs
    if pairs.count == costs.shape[0]:
        pairs.count -= 1
        for i in range(pairs.count):
            infeasibilities[i], costs[i] = infeasibilities[i + 1], costs[i + 1]
    infeasibilities[pairs.count], costs[pairs.count] = infeasibility, cost
    pairs.count += 1
