"""Costs of optimal control problems."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import DimensionError
from doorman.one_line import OneLine

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class QuadraticCost(OneLine):
    r"""Diagonal quadratic cost (the paper's).

    .. math::
        J = \tfrac12\|x_N - x^g\|^2_L
            + \sum_{k=0}^{N-1}\Big(\tfrac12\|x_k - x^g\|^2_Q + \tfrac12\|u_k - u^g\|^2_R\Big)\Delta t
    """

    state_weights: Array
    """Diagonal of Q, shape (nx,), not negative."""
    terminal_weights: Array
    """Diagonal of L, shape (nx,), not negative."""
    input_weights: Array
    """Diagonal of R, shape (nu,), positive."""
    state_goal: Array
    """x^g, shape (nx,)."""
    input_goal: Array
    """u^g, shape (nu,)."""

    def __post_init__(self) -> None:
        for field in fields(self):
            array = np.array(getattr(self, field.name), dtype=np.float64)
            if array.ndim != 1 or not np.isfinite(array).all():
                raise DimensionError("not a vector of finite numbers", field=field.name, given=array.tolist())
            array.flags.writeable = False
            object.__setattr__(self, field.name, array)
        nx, nu = len(self.state_goal), len(self.input_goal)
        for name, size in (("state_weights", nx), ("terminal_weights", nx), ("input_weights", nu)):
            weights = getattr(self, name)
            if len(weights) != size:
                raise DimensionError("wrong length", field=name, given=len(weights), allowed=str(size))
            if (weights < 0.0).any() or (name == "input_weights" and (weights <= 0.0).any()):
                raise DimensionError(
                    "negative weight", field=name, given=weights.tolist(), allowed="> 0 for inputs, else >= 0"
                )

    def total(self, states: Array, inputs: Array, time_step: float) -> float:
        """J of a trajectory.

        Args:
            states: Shape (N + 1, nx).
            inputs: Shape (N, nu).
            time_step: Δt [s].

        Returns:
            The cost.
        """
        state_error, input_error = states - self.state_goal, inputs - self.input_goal
        stage = (state_error[:-1] ** 2 @ self.state_weights).sum() + (input_error**2 @ self.input_weights).sum()
        return float(0.5 * (time_step * stage + state_error[-1] ** 2 @ self.terminal_weights))
