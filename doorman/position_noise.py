"""White noise of measured positions, by second differences: motion hardly shows in them."""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Sequence

import numpy as np

from doorman.arrays import Array

_KEPT = 1000
_ENOUGH = 50
"""Second differences from which on the noise is known."""
_MEDIAN_OF_SQUARES = 2.366
"""Median of the squared length of three normal numbers."""


class PositionNoise:
    """Collects positions that were taken at even times, the last thousand of them."""

    def __init__(self) -> None:
        self._last: deque[tuple[int, list[float]]] = deque(maxlen=3)
        self._bent: deque[float] = deque(maxlen=_KEPT)

    def note(self, number: int, position: Sequence[float] | Array) -> None:
        """Take in one position; three with a gap between them tell nothing."""
        self._last.append((number, np.asarray(position, dtype=np.float64).tolist()))
        if len(self._last) < 3 or number - self._last[0][0] != 2:
            return
        (_, (x, y, z)), (_, (x_then, y_then, z_then)), (_, (x_now, y_now, z_now)) = self._last
        x, y, z = x - 2.0 * x_then + x_now, y - 2.0 * y_then + y_now, z - 2.0 * z_then + z_now
        self._bent.append(x * x + y * y + z * z)

    @property
    def deviation(self) -> float:
        """Standard deviation on every axis, by the median, so that jumps do not count; NaN before it is known [m]."""
        if len(self._bent) < _ENOUGH:
            return math.nan
        summed = 1.0 + 2.0**2 + 1.0  # variance of a second difference, in variances of the noise
        return math.sqrt(statistics.median(self._bent) / (_MEDIAN_OF_SQUARES * summed))
