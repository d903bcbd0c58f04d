"""Times that come by chance: gaps in which a sensor says nothing new, and jumps of the wind or of the poses' frame."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


class Dropouts:
    """Gaps by chance."""

    def __init__(self, rate: float, longest: float, seed: int | Sequence[int]) -> None:
        self._rate, self._longest = rate, longest
        self._generator = np.random.default_rng(seed)
        self._begin, self._end = math.inf, 0.0
        if rate > 0.0 and longest > 0.0:
            self._next_gap()

    def lost(self, time: float) -> bool:
        """Whether what is seen at this time is lost; times must not decrease."""
        while time >= self._end and self._begin < math.inf:
            self._next_gap()
        return time >= self._begin

    def _next_gap(self) -> None:
        self._begin = self._end + self._generator.exponential(1.0 / self._rate)
        self._end = self._begin + self._generator.uniform(0.0, self._longest)


class Jumps:
    """A Poisson process, with random numbers of its own."""

    def __init__(self, rate: float, seed: tuple[int, int]) -> None:
        self._rate = rate
        self.generator = np.random.default_rng(list(seed))  # for what jumps draw
        self._next = math.inf
        if rate > 0.0:
            self._next = self._wait()

    def since(self, time: float) -> int:
        """Number of jumps since the last call."""
        count = 0
        while time >= self._next:
            count += 1
            self._next += self._wait()
        return count

    def _wait(self) -> float:
        return float(self.generator.exponential(1.0 / self._rate))
