"""Statistics of successes."""

from __future__ import annotations

import math

_QUANTILE = 1.959963984540054
"""Quantile of the normal distribution for 95 %."""


def wilson_interval(successes: int, runs: int) -> tuple[float, float]:
    """Wilson's 95 % confidence interval of a success rate p: (p + z²/2n ± z √(p(1−p)/n + z²/4n²)) / (1 + z²/n)."""
    if runs == 0:
        return 0.0, 1.0
    share, z2 = successes / runs, _QUANTILE**2 / runs
    center = share + z2 / 2
    half = math.sqrt(z2 * (share * (1.0 - share) + z2 / 4))
    return max((center - half) / (1.0 + z2), 0.0), min((center + half) / (1.0 + z2), 1.0)
