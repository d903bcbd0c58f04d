"""What kernels and Python tell each other: costs, counts and flags of one solve."""

from __future__ import annotations

from doorman.numba_types.records import Record


class Result(Record):
    """Numbers of the present solve, and what iterations that pause go on with."""

    cost: float
    """J of the trajectory that was evaluated last."""
    iterations: int
    sweeps: int
    """Riccati sweeps since this was last set to zero."""
    decrease: float
    """Decrease of the cost that the last sweep predicts."""
    change: float
    """Largest change of an input by the last sweep, weighted by its cost."""
    costate: float
    """Largest entry of V_x in the last sweep."""
    settled: bool
    """Whether the last step fits the active set that it was found with."""
    price: float
    """What the last change of the multipliers was worth, in units of the cost."""
    priced_out: bool
    """Whether a multiplier has reached its largest value."""
    defect: float
    """Largest |e|."""
    violation: float
    """Largest violated row or bound."""
    infeasibility: float
    """Sum of defects and violations."""
    node: int
    """Node of the worst violation."""
    row: int
    """Row of the worst violation, numbered as in `Program`."""
    last_violated: int
    """Last node at which a row or bound is violated by more than `settings.feasibility`; −1 if none is."""
    expected: float
    """J of what the iterations ended with, before it was rolled out."""
    rolled: float
    """J of the last rollout of `follow`, also where its guess is better; ∞ where it violates something."""
    guess: float
    """J of the first guess in `Workspace.guess`; NaN where there is none yet, or where that of `follow` is not feasible."""
    guess_price: float
    """What the violations and defects of the guess of `follow` are worth at most."""
    near: bool
    """Whether derivatives along the nominal trajectory are good enough for a rollout's first corrections."""
    corrections: int
    """Corrections that the node had had where a rollout stopped."""
    relaxed: int
    """Nodes at which no input was good enough for all rows."""
    rollout_time: float
    """Duration of the last rollout [s]."""
    pause: float
    """Time after which iterations come back to be called again: 0 after each of them, ∞ never [s]."""
    resumes: bool
    """Whether iterations go on from their pause."""
    penalty: float
    """1/μ of the present iteration."""
    regularization: float
    """Regularisation with which the next iteration begins."""
    sweep_limit: int
    """Largest number of sweeps of the next fast iteration."""
    settle: float
    """Predicted decrease, relative to 1 + |J|, below which a careful step moves the multipliers."""
    violation_before: float
    """Violation when a careful step last moved them."""
