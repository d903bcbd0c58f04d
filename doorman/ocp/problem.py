"""Optimal control problem: what is to be solved, without a word on how."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from doorman.exceptions import DimensionError
from doorman.ocp.costs import QuadraticCost


@dataclass(frozen=True)
class Problem:
    r"""Minimise a cost subject to dynamics and hard constraints on every state after the first.

    .. math:: \min_U J(X, U)\quad\text{s.t.}\quad x_{k+1} = f(x_k, u_k),\quad h(x_{k+1}) \le 0,\quad k = 0 \ldots N-1
    """

    model: Any
    """NamedTuple whose type has implementations of the functions in `doorman.ocp.functions`."""
    n_constraints: int
    """Number of rows of h."""
    horizon: int
    """N, number of steps."""
    time_step: float
    """Δt [s]."""
    cost: QuadraticCost

    def __post_init__(self) -> None:
        if self.horizon < 1:
            raise DimensionError("empty horizon", field="horizon", given=self.horizon, allowed=">= 1")
        if not self.time_step > 0.0:
            raise DimensionError("no time step", field="time_step", given=self.time_step, allowed="> 0 s")

    @property
    def nx(self) -> int:
        """Number of states."""
        return len(self.cost.state_goal)

    @property
    def nu(self) -> int:
        """Number of inputs."""
        return len(self.cost.input_goal)
