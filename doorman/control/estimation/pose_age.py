r"""How old poses may be: what carries them on must be faster than the loop that it feeds.

The position loop k_p + k_d s crosses over at

.. math::
    \omega_c^2 = \tfrac12 \Big( k_d^2 + \sqrt{k_d^4 + 4 k_p^2} \Big),

and an observer of a pose of age t has a bandwidth of at most :math:`0.6/t`: more would make it unstable. So

.. math::
    t \le \frac{0.6}{r\,\omega_c}

with the ratio r of both. Flights of `paper` and `push` with poses of 1 mm and 0.2° of noise end near the goal at r = 2.7. They
miss it by 1 to 2° at 2.4, and lose door or contact at 2.0.
"""

from __future__ import annotations

import math

from doorman.scenario import ControlSection

LATEST = 0.6
"""Largest product of bandwidth and age."""
_RATIO = 2.6
"""r: with less, contact is lost."""


def crossover(control: ControlSection) -> float:
    """ω_c of the position loop along the ground, where contact is [rad/s]."""
    pairs = zip(control.position_gain[:2], control.velocity_gain[:2], strict=True)
    return max(math.sqrt(0.5 * (d * d + math.sqrt(d**4 + 4.0 * p * p))) for p, d in pairs)


def oldest_pose(control: ControlSection) -> float:
    """Age of a pose, just before the next one comes, up to which contact is stable [s]."""
    return LATEST / (_RATIO * crossover(control))
