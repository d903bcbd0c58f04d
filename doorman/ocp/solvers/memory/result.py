"""Scalars that kernels and Python tell each other, by their places in one array."""

from __future__ import annotations

from typing import NamedTuple


class Result(NamedTuple):
    """Positions in `Workspace.result`."""

    COST: int = 0
    """J of the trajectory that was evaluated last."""
    ITERATIONS: int = 1
    DECREASE: int = 2
    """Decrease of the cost that the last sweep predicts."""
    CHANGE: int = 3
    """Largest change of an input by the last sweep, weighted by its cost."""
    DEFECT: int = 4
    """Largest |e|."""
    VIOLATION: int = 5
    """Largest violated row or bound."""
    INFEASIBILITY: int = 6
    """Sum of defects and violations."""
    NODE: int = 7
    """Node at which a kernel stopped, or where the worst violation is."""
    ROW: int = 8
    """Row of the worst violation, numbered as in `Program`."""
    ENTRIES: int = 9
    """Number of pairs in the filter."""
    PENALTY: int = 10
    """1/μ with which the fast iterations ended."""
    RELAXED: int = 11
    """Nodes at which no input was good enough for all rows."""
    CORRECTIONS: int = 12
    """Corrections that the node had had where a rollout stopped."""
    PRICED_OUT: int = 13
    """1 if a multiplier has reached its largest value."""
    SETTLED: int = 14
    """1 if the last step fits the active set that it was found with."""
    COSTATE: int = 15
    """Largest entry of V_x in the last sweep."""
    SWEEPS: int = 16
    """Riccati sweeps since this was last set to zero."""
    PRICE: int = 17
    """What the last change of the multipliers was worth, in units of the cost."""
    NEAR: int = 18
    """1 while derivatives along the nominal trajectory are good enough for a rollout's first corrections."""
    EXPECTED: int = 19
    """J of what the iterations ended with, before it was rolled out."""
    ROLLOUT_TIME: int = 20
    """Duration of the last rollout [s]."""
    PAUSE: int = 21
    """Time after which iterations come back to be called again: 0 after each of them, ∞ never [s]."""
    REGULARIZATION: int = 22
    """What iterations that pause go on with."""
    SWEEP_LIMIT: int = 23
    SETTLE: int = 24
    LAST_VIOLATION: int = 25
    RESUMES: int = 26
    """1 where iterations go on from their pause."""
    GUESS: int = 27
    """J of the first guess in `Workspace.guess`; NaN where there is none yet, or where that of `follow` is not feasible."""
    GUESS_PRICE: int = 28
    """What the violations and defects of the guess of `follow` are worth at most."""
    ROLLED: int = 29
    """J of the last rollout of `follow`, also where its guess is better; ∞ where it violates something."""
    LAST: int = 30
    """Last node at which a row or bound is violated by more than `settings.feasibility`; −1 if none is."""


RESULT = Result()
