"""What a filter knows at one time."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from doorman.arrays import Array, sealed
from doorman.stored_at_once import stored_at_once


@stored_at_once
@dataclass(frozen=True, eq=False)
class FilterEstimate:
    """Mean and covariance of all hypotheses together, and how likely each of them is; arrays are read-only."""

    time: float
    """[s]."""
    report: Array
    """All of its numbers, as `bank.fill_report` writes them."""
    mean: Array
    """Shape (n,)."""
    deviations: Array
    """Standard deviations of the states, shape (n,)."""
    hypotheses: tuple[str, ...]
    """Their names."""
    output_names: tuple[str, ...]

    @property
    def chances(self) -> Array:
        """Probability of each hypothesis, in their order, shape (M,)."""
        return sealed(self.report[2 * self.mean.size : 2 * self.mean.size + len(self.hypotheses)])

    @property
    def values(self) -> Array:
        """Values of the outputs in their order, then their deviations, shape (2 k,)."""
        first = 2 * self.mean.size + len(self.hypotheses)
        return sealed(self.report[first : first + 2 * len(self.output_names)])

    @property
    def covariance(self) -> Array:
        """Shape (n, n)."""
        n = self.mean.size
        first = 2 * n + len(self.hypotheses) + 2 * len(self.output_names)
        return sealed(self.report[first : first + n * n].reshape(n, n))

    @property
    def probabilities(self) -> Mapping[str, float]:
        """By hypothesis."""
        return MappingProxyType(dict(zip(self.hypotheses, self.chances.tolist(), strict=True)))

    @property
    def means(self) -> Mapping[str, Array]:
        """Mean under each hypothesis."""
        rows = sealed(self.report[-len(self.hypotheses) * self.mean.size :].reshape(-1, self.mean.size))
        return MappingProxyType(dict(zip(self.hypotheses, rows, strict=True)))

    @property
    def outputs(self) -> Mapping[str, tuple[float, float]]:
        """Value and deviation of each output."""
        values, deviations = self.values.reshape(2, -1).tolist()
        pairs = zip(values, deviations, strict=True)
        return MappingProxyType(dict(zip(self.output_names, pairs, strict=True)))

    def probability_of(self, names: Collection[str]) -> float:
        """How likely it is that one of these hypotheses is true."""
        chances = zip(self.hypotheses, self.chances.tolist(), strict=True)
        return float(sum([chance for name, chance in chances if name in names]))


@dataclass(frozen=True)
class MeasurementScore:
    """How one kind of measurement fared since the start."""

    fused: int
    refused: int
    mean_nis: float
    """Mean normalised innovation squared of what was fused: the number of its rows, if model and noise are right. NaN before the
    first."""
