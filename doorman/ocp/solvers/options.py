"""Settings that the solvers share."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from doorman.exceptions import SolverError

Hessian = Literal["both", "exact", "gauss-newton"]
HESSIANS: tuple[Hessian, ...] = ("both", "exact", "gauss-newton")


@dataclass(frozen=True)
class SolverOptions:
    """Settings of a solver; what one of them does not use, it passes over."""

    hessian: Hessian = "both"
    """How `Hybrid` searches. "gauss-newton": fast iterations, whose Hessian leaves out the curvature of dynamics and
    constraints. "exact": an interior-point search with the Hessian of the Lagrangian. "both": fast iterations, and the search
    where these do not end at a minimum. A model without second derivatives has differences of its first ones."""
    tolerance: float = 3e-8
    """Converged when the predicted decrease of the cost is below this, relative to 1 + |cost|."""
    feasibility: float = 1e-6
    """A trajectory counts as feasible up to this violation [the row's unit]."""
    penalty: float = 3e3
    """1/μ of the augmented Lagrangian, the same for all rows: cost by the row's unit squared."""
    largest_multiplier: float = 1e6
    """Rows cost no more than this by unit of violation: where they cannot hold, as after a start outside, the iterations settle
    for the least violation that this price leaves worth while."""
    sweeps: int = 3
    """Largest number of Riccati sweeps on one linearisation; more where the active set keeps changing."""
    guess_active_sets: bool = True
    """Try a guess of a node's active set before ProxQP; a guess counts only if it solves the node exactly."""
    smallest_step: float = 1.0 / 64.0
    """Shortest step of CDDP's line search before regularisation grows."""
    sufficient_decrease: float = 1e-4
    """Share of the predicted decrease that a step of CDDP must bring."""
    first_regularization: float = 1e-3
    """Relative addition to the input weights after a line search has failed; each further failure takes ten times more."""
    largest_regularization: float = 1e6

    def __post_init__(self) -> None:
        if self.hessian not in HESSIANS:
            raise SolverError("unknown", field="options.hessian", given=self.hessian, allowed=", ".join(HESSIANS))
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name not in ("guess_active_sets", "hessian") and not value > 0.0:
                raise SolverError("not positive", field=f"options.{field.name}", given=value, allowed="> 0")
