r"""Hypotheses: what a filter of the bank takes for true, beside the model.

Each hypothesis may have dynamics and noise of its own, and rows: :math:`g(x, u, p) = 0 \pm \sigma` narrows the state,
:math:`g \ge 0` does not. A row that does not hold makes the hypothesis less likely: for each independent look it costs

.. math:: \tfrac12 \max(g^2 - G P G^T, 0) / (G P G^T + \sigma^2)

of log-likelihood, so that what the filter itself does not know costs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, eq=False)
class Row:
    """An expression that a hypothesis sets to zero, or keeps from being negative.

    Args:
        name: For messages.
        expression: g of the model's symbols, (r, 1).
        deviation: σ by which it may be off, (r, 1), or one for all [unit of the row].
        lasts: Time after which it is off in another way [s]; two looks within it count as one. 0: every look is independent.
    """

    name: str
    expression: Any
    deviation: Any
    lasts: Any = 0.0


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One of the ways in which the process may go on.

    Args:
        name: By which its probability is known.
        dynamics: f of the model's symbols, (n, 1); the model's own if not given.
        noise: As in `ProcessModel`; the model's own if not given.
        holds: Rows that are zero.
        limits: Rows that are not negative.
    """

    name: str
    dynamics: Any = None
    noise: Any = None
    holds: Sequence[Row] = ()
    limits: Sequence[Row] = ()
