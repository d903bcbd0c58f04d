"""Swaps of markers: for a while the cameras take some for others, and every pose is off by as much."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.scenario import SensorsSection
from doorman.simulation.gaps import Dropouts

Array = NDArray[np.float64]

_TIMES, _SIZES = 9, 10
"""Streams of one seed's random numbers that make times and directions."""


class Swaps:
    """Swaps of one flight; the seed is that of times and directions."""

    def __init__(self, section: SensorsSection, seed: int) -> None:
        self._section, self._generator = section, np.random.default_rng([seed, _SIZES])
        self._times = Dropouts(section.swap_rate, section.swap_duration, [seed, _TIMES])
        self._off: Array | None = None

    def off(self, time: float) -> Array:
        """By how much position [m] and attitude [rad] are off now, shape (6,); times must not decrease."""
        if not self._times.lost(time):
            self._off = None
            return np.zeros(6)
        if self._off is None:
            moved, turned = (each / np.linalg.norm(each) for each in self._generator.standard_normal((2, 3)))
            self._off = np.concatenate((self._section.swap * moved, self._section.swap_turn * turned))
        return self._off
