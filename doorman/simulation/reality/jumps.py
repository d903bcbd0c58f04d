"""Times that come by chance: of jumps of the wind, and of the frame in which poses are seen."""

from __future__ import annotations

import math

import numpy as np


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
