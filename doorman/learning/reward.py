r"""Reward of a step: what the potential of the state has grown by, less what the step cost.

.. math::
    r = \Phi(s_{k+1}) - \Phi(s_k) - \bigl(w_t + w_u \lVert a \rVert^2 + w_\omega \lVert \Omega \rVert^2\bigr) T
      + w_g [\text{opened}] - w_c [\text{failed}], \qquad
    \Phi = w_p \Bigl(1 - \frac{|\alpha - \alpha_g|}{|\alpha_0 - \alpha_g|}\Bigr) - w_d \min(d / 0.5\,\text{m}, 1)

with the distance d of the tip from the contact point on the leaf. Over an episode the potential adds up to its change from start
to end, whatever the way and the length of a step: it leads to the goal and leaves the best policy as it is (Ng, Harada and
Russell, ICML 1999, without discount).

A failure costs more than to hover for twenty seconds, and as much as a quarter of the way is worth: trying beats hovering, and
hovering beats falling.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from doorman.arrays import Array


@dataclass(frozen=True)
class RewardWeights:
    """Weights of the terms.

    Example:
        >>> from doorman.learning import RewardWeights
        >>> RewardWeights(action=0.0).progress
        10.0
    """

    progress: float = 10.0
    """w_p: for the whole way of the leaf."""
    contact: float = 1.0
    """w_d: for a tip at an arm's length from the contact point, against one that is there."""
    opened: float = 10.0
    """w_g: once, at the goal."""
    failed: float = 2.5
    """w_c: once, for a collision, a fall, or leaving the room."""
    time: float = 0.1
    """w_t [1/s]."""
    action: float = 0.01
    """w_u [1/s]."""
    body_rates: float = 0.01
    """w_ω [s/rad²]."""


class Place(NamedTuple):
    """What the potential is made of."""

    away: float  # |α − α_g| [rad]
    whole: float  # |α − α_g| at the start [rad]
    gap: float  # d, of the tip from the contact point [m]


def reward_terms(
    weights: RewardWeights,
    before: Place,
    after: Place,
    action: Array,
    body_rates: Array,
    duration: float,
    opened: bool = False,
    failed: bool = False,
) -> dict[str, float]:
    """Terms of the reward by name; it is their sum."""
    near, far = (min(place.gap / 0.5, 1.0) for place in (after, before))  # farther than an arm's length is as bad
    return {
        "progress": weights.progress * (before.away - after.away) / before.whole,
        "contact": weights.contact * (far - near),
        "time": -weights.time * duration,
        "action": -weights.action * float(action @ action) * duration,
        "body_rates": -weights.body_rates * float(body_rates @ body_rates) * duration,
        "opened": weights.opened * opened,
        "failed": -weights.failed * failed,
    }
