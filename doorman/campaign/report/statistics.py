"""Statistics of successes."""

from __future__ import annotations

import math

_QUANTILE = 1.959963984540054
"""Quantile of the normal distribution for 95 %."""


def wilson_interval(successes: int, runs: int) -> tuple[float, float]:
    r"""Wilson's 95 % confidence interval of a success rate.

    .. math::
        \frac{\hat p + \frac{z^2}{2n} \pm z\sqrt{\frac{\hat p (1 - \hat p)}{n} + \frac{z^2}{4n^2}}}{1 + \frac{z^2}{n}}
    """
    if runs == 0:
        return 0.0, 1.0
    share, z2 = successes / runs, _QUANTILE**2 / runs
    center = share + z2 / 2
    half = math.sqrt(z2 * (share * (1.0 - share) + z2 / 4))
    return max((center - half) / (1.0 + z2), 0.0), min((center + half) / (1.0 + z2), 1.0)
