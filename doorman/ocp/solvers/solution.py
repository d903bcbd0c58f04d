"""What a solver returns: a trajectory, how good it is, and whether it may be used."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from doorman.arrays import Array
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.memory.parts import Multipliers
from doorman.ocp.solvers.stretch import with_stretch
from doorman.ocp.solvers.sweeps.kkt import Conditions, conditions
from doorman.one_line import OneLine


class PlanStatus(Enum):
    """How a solve ended."""

    CONVERGED = "converged"
    """Optimal to the tolerance; dynamics and constraints hold."""
    ITERATION_LIMIT = "iteration limit"
    """Out of iterations or time; dynamics and constraints hold, the cost may still fall."""
    STALLED = "stalled"
    """No step lowers the cost any further at any regularisation; dynamics and constraints hold."""
    RELAXED = "relaxed"
    """As at the limit of iterations; but constraints that the start violates are widened until they contain it."""
    RECOVERING = "recovering"
    """The start violates constraints, or leads into them, faster than the bounds of the inputs allow to correct: dynamics and
    these bounds hold, the constraints hold from some node on to the end. To be flown where the start is where the vehicle is."""
    INFEASIBLE = "infeasible"
    """No trajectory inside the constraints was found: not to be flown."""
    CANNOT_OPEN = "door cannot be opened"
    """The door resists by more than the vehicle can push with its tilt and thrust: not to be flown."""
    CANNOT_STOP = "door cannot be stopped"
    """No trajectory was found because a tip that can only push would set a standing door in motion that nothing stops: not to
    be flown."""
    DIVERGED = "diverged"
    """A number is not finite: not to be flown."""
    INVALID_STATE = "invalid state"
    """The dynamics or constraints have no finite value at the start: not to be flown."""

    @property
    def usable(self) -> bool:
        """Whether dynamics and constraints hold along the whole trajectory."""
        return self in _USABLE

    @property
    def flyable(self) -> bool:
        """Whether it may be flown: usable, or the way back to where constraints hold."""
        return self in _FLYABLE


_USABLE = (PlanStatus.CONVERGED, PlanStatus.ITERATION_LIMIT, PlanStatus.STALLED, PlanStatus.RELAXED)
_FLYABLE = (*_USABLE, PlanStatus.RECOVERING)


@dataclass(frozen=True)
class Timings:
    """Where the time of one solve went [s]."""

    total: float
    iterations: float
    """Linearisations, sweeps and line searches."""
    rollout: float
    """Rollouts onto dynamics and constraints."""


@dataclass(frozen=True, eq=False, repr=False)
class Solution(OneLine):
    """Trajectory and diagnosis of one solve; arrays are read-only."""

    problem: Problem
    """What was solved."""
    states: Array
    """X, shape (N + 1, nx)."""
    inputs: Array
    """U, shape (N, nu)."""
    time_step: float
    """Δt, where the time is free the one that was found [s]."""
    gains: Array
    """Feedback u = U_k + K_k (x − X_k), shape (N, nu, nx)."""
    multipliers: Multipliers
    """Multipliers of constraints and bounds; a free time adds a column, that of the stretch."""
    cost: float
    """J of the trajectory."""
    violation: float
    """Largest violated row or bound at any node, 0 inside [the row's unit]."""
    violation_node: int
    """Its node."""
    violation_row: int
    """Its row, as `constraint_name` counts."""
    recovered_at: int
    """First node from which on everything holds; N + 1 if there is none."""
    defect: float
    """Largest |f(x_k, u_k) − x_{k+1}|."""
    iterations: int
    """Linearisations and sweeps."""
    status: PlanStatus
    """How the solve ended, and whether the trajectory may be used."""
    timings: Timings
    """Where the time went."""

    @property
    def duration(self) -> float:
        """Duration of the horizon [s]."""
        return self.problem.horizon * self.time_step

    @property
    def solve_time(self) -> float:
        """Time of the whole solve [s]."""
        return self.timings.total

    @property
    def max_violation(self) -> float:
        """Largest violated row or bound at any node, `violation` [the row's unit]."""
        return self.violation

    @property
    def usable(self) -> bool:
        """Whether dynamics and constraints hold along the whole trajectory."""
        return self.status.usable

    @property
    def constraint_name(self) -> str:
        """Name of the row of `violation`."""
        return row_name(self.problem, self.violation_row)

    @cached_property
    def kkt_residual(self) -> float:
        """Largest gradient of the Lagrangian by an input, with costates from the multipliers; computed at the first use."""
        return self._conditions.residual

    @cached_property
    def costates(self) -> Array:
        """Multipliers p of the dynamics, from the others; computed at the first use, shape (N, nx).

        The Lagrangian has p_kᵀ (f(x_k, u_k) − x_{k+1}) in it: a push d on state k + 1 changes J by p_kᵀ d.
        """
        return self._conditions.costates[:, : self.states.shape[1]]

    @cached_property
    def _conditions(self) -> Conditions:
        states, inputs = with_stretch(self.problem, self.states, self.inputs, self.time_step)
        return conditions(self.problem, states, inputs, self.multipliers)

    def message(self) -> str:
        """One sentence on how the solve ended; where constraints are violated, which, where and by how much."""
        words = f"{self.status.value} after {self.iterations} iterations, cost {self.cost:.6g}"
        if self.violation > 1e-6:
            words += f"; {self.constraint_name} violated by {self.violation:.3g} at node {self.violation_node}"
            if self.recovered_at <= self.problem.horizon:
                words += f", everything holds from node {self.recovered_at} on"
        return words


def row_name(problem: Problem, row: int) -> str:
    """Name of a row."""
    nh, ng, nt = problem.n_constraints, problem.n_input_constraints, problem.n_end_constraints
    if row < nh + nt + ng:
        order = [*range(nh), *range(nh + ng, nh + ng + nt), *range(nh, nh + ng)]  # names are of h, g and h_N
        return problem.constraint_names[order[row]] if problem.constraint_names else f"constraint {order[row]}"
    names = []
    for what, size in (("state", problem.nx), ("input", problem.nu)):
        for i in range(size):
            name = "the duration" if what == "input" and i == problem.given_inputs else f"{what} {i}"
            for end in ("upper", "lower"):
                if np.isfinite(np.asarray(getattr(problem.bounds, f"{what}_{end}"))[i]):
                    names.append(f"{end} bound of {name}")
    return names[row - nh - nt - ng]
