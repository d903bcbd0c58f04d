"""What a solver returns: a trajectory, how good it is, and whether it may be used."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class PlanStatus(Enum):
    """How a solve ended."""

    CONVERGED = "converged"
    """Optimal to the tolerance; dynamics and constraints hold."""
    ITERATION_LIMIT = "iteration limit"
    """Out of iterations; dynamics and constraints hold, the cost may still fall."""
    STALLED = "stalled"
    """No step lowers the cost any further at any regularisation; dynamics and constraints hold."""
    INFEASIBLE = "infeasible"
    """No input brings the next state inside the constraints at some node: not to be flown."""
    DIVERGED = "diverged"
    """A number is not finite: not to be flown."""

    @property
    def usable(self) -> bool:
        """Whether dynamics and constraints hold along the trajectory."""
        return self in (PlanStatus.CONVERGED, PlanStatus.ITERATION_LIMIT, PlanStatus.STALLED)


@dataclass(frozen=True)
class Solution:
    """Trajectory and diagnosis of one solve; arrays are read-only."""

    states: Array
    """X, shape (N + 1, nx)."""
    inputs: Array
    """U, shape (N, nu)."""
    gains: Array
    """Feedback u = U_k + K_k (x − X_k), shape (N, nu, nx)."""
    multipliers: Array
    """Of the constraints at nodes 1 … N, shape (N, nh), not negative."""
    cost: float
    max_violation: float
    """Largest h over the nodes 1 … N (with the problem's margin); zero or negative inside."""
    stationarity: float
    """Largest predicted change of an input, weighted by its cost: zero at a KKT point."""
    iterations: int
    status: PlanStatus
    solve_time: float
    """[s]."""
    worst_node: int
    """Node of `max_violation`."""
    worst_constraint: int
    """Row of `max_violation`."""
