r"""Reward of a step: how much nearer the leaf came to its goal, less what it cost.

.. math::
    r = w_p \frac{|\alpha_k - \alpha_g| - |\alpha_{k+1} - \alpha_g|}{|\alpha_0 - \alpha_g|}
      - \bigl(w_u \lVert a \rVert^2 + w_\omega \lVert \Omega \rVert^2\bigr) T + w_g [\text{opened}] - w_c [\text{failed}]

Over an episode the first term adds up to w_p for a door that is opened, whatever the length of a step.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RewardWeights:
    """Weights of the terms."""

    progress: float = 10.0
    """w_p: for the whole way of the leaf."""
    opened: float = 10.0
    """w_g: once, at the goal."""
    failed: float = 10.0
    """w_c: once, for a collision, a fall, or leaving the room."""
    action: float = 0.02
    """w_u [1/s]."""
    body_rates: float = 0.02
    """w_ω [s/rad²]."""


@dataclass(frozen=True)
class Step:
    before: float  # |α − α_g| before [rad]
    after: float  # |α − α_g| after [rad]
    whole: float  # |α − α_g| at the start [rad]
    action_squared: float
    rates_squared: float  # [rad²/s²]
    duration: float  # T [s]
    opened: bool
    failed: bool


def reward_terms(weights: RewardWeights, step: Step) -> dict[str, float]:
    """Terms of the reward by name; it is their sum."""
    return {
        "progress": weights.progress * (step.before - step.after) / step.whole,
        "action": -weights.action * step.action_squared * step.duration,
        "body_rates": -weights.body_rates * step.rates_squared * step.duration,
        "opened": weights.opened * step.opened,
        "failed": -weights.failed * step.failed,
    }
