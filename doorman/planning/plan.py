"""A plan: one second or so of motion, and how its solve ended."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.arrays import Array
from doorman.ocp.solvers.solution import PlanStatus
from doorman.one_line import OneLine


@dataclass(frozen=True, eq=False, repr=False)
class Plan(OneLine):
    """One second or so of motion; arrays are read-only."""

    states: Array
    """x_0 … x_N, shape (N + 1, nx); the first is the state that was given."""
    inputs: Array
    """u_0 … u_{N−1}, shape (N, nu)."""
    cost: float
    """J, the paper's cost; its goal leans against a disturbance of the hinge (`PlanningModel.goal`)."""
    max_violation: float
    """Largest excess of a hard limit over 0 at nodes 1 … N: of a constraint or a bound [the row's unit, divided by its scale].
    In a quasi-static plan the planner's margin is part of the limit; in a whole-body plan that of the rotor disc is soft."""
    iterations: int
    """Iterations of the solver: linearisations and sweeps."""
    status: PlanStatus
    """How the solve ended, and whether the plan may be flown."""
    solve_time: float
    """Duration of the whole call [s]."""
    time_step: float
    """Δt between nodes [s]."""
    violated: str = ""
    """Where a constraint is violated: its name, the node and the amount of the worst one; of a door that cannot be opened, the
    numbers; else empty."""

    @property
    def usable(self) -> bool:
        """Whether dynamics and constraints hold along the plan."""
        return self.status.usable

    @property
    def flyable(self) -> bool:
        """Whether it may be flown: usable, or the way back to where constraints hold."""
        return self.status.flyable
