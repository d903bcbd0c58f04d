"""What a filter knows at one time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.stored_at_once import stored_at_once


@stored_at_once
@dataclass(frozen=True)
class FilterEstimate:
    """Mean and covariance of all hypotheses together, and how likely each of them is; arrays are read-only."""

    time: float
    """[s]."""
    mean: Array
    """Shape (n,)."""
    covariance: Array
    """Shape (n, n)."""
    probabilities: Mapping[str, float]
    """By hypothesis."""
    means: Mapping[str, Array]
    """Mean under each hypothesis."""
    outputs: Mapping[str, tuple[float, float]]
    """Value and deviation of each output."""

    def probability_of(self, names: Iterable[str]) -> float:
        """How likely it is that one of these hypotheses is true."""
        total, probabilities = 0.0, self.probabilities
        for name in names:
            total += probabilities.get(name, 0.0)
        return total

    @property
    def deviations(self) -> Array:
        """Standard deviations of the states, shape (n,)."""
        return np.sqrt(self.covariance.diagonal())


@dataclass(frozen=True)
class MeasurementScore:
    """How one kind of measurement fared since the start."""

    fused: int
    refused: int
    mean_nis: float
    """Mean normalised innovation squared of what was fused: the number of its rows, if model and noise are right. NaN before the
    first."""
