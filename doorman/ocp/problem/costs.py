"""Costs of optimal control problems."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.exceptions import DimensionError
from doorman.one_line import OneLine


@dataclass(frozen=True, eq=False, repr=False, init=False)
class QuadraticCost(OneLine):
    r"""Quadratic cost, the paper's where its weights are diagonal.

    .. math::
        J = \tfrac12\|x_N - x^g\|^2_L
            + \sum_{k=0}^{N-1}\Big(\tfrac12\|x_k - x^g\|^2_Q + \tfrac12\|u_k - u^g\|^2_R
            + (u_k - u^g)^T S (x_k - x^g)\Big)\Delta t

    Weights are diagonals or symmetric matrices. Diagonals take less time.
    """

    state_weights: Array
    """Q, its diagonal (nx,) or (nx, nx), positive semidefinite."""
    terminal_weights: Array
    """L, its diagonal (nx,) or (nx, nx), positive semidefinite."""
    input_weights: Array
    """R, its diagonal (nu,) or (nu, nu), positive semidefinite; where it is zero, other terms have to curve the cost."""
    state_goal: Array
    """x^g, shape (nx,)."""
    input_goal: Array
    """u^g, shape (nu,)."""
    cross_weights: Array | None = None
    """S, shape (nu, nx), where there is one; [Q Sᵀ; S R] is positive semidefinite."""

    def __init__(
        self, state_weights: ArrayLike, terminal_weights: ArrayLike, input_weights: ArrayLike, state_goal: ArrayLike,
        input_goal: ArrayLike, cross_weights: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        everything = (state_weights, terminal_weights, input_weights, state_goal, input_goal, cross_weights)
        for field, given in zip(fields(self), everything, strict=True):
            array = None if given is None and field.name == "cross_weights" else _numbers(field.name, given)
            object.__setattr__(self, field.name, array)
        nx, nu = len(self.state_goal), len(self.input_goal)
        for name, size in (("state_weights", nx), ("terminal_weights", nx), ("input_weights", nu)):
            _check_weights(name, getattr(self, name), size)
        if self.cross_weights is not None:
            if self.cross_weights.shape != (nu, nx):
                raise DimensionError(
                    "wrong shape", field="cross_weights", given=self.cross_weights.shape, allowed=str((nu, nx))
                )
            state, _, inputs, cross = self.matrices()
            _check_definite("cross_weights", np.block([[state, cross.T], [cross, inputs]]))

    @property
    def is_full(self) -> bool:
        """Whether there is more than diagonals."""
        return self.cross_weights is not None or any(
            weights.ndim == 2 for weights in (self.state_weights, self.terminal_weights, self.input_weights)
        )

    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """Q (nx, nx), L (nx, nx), R (nu, nu) and S (nu, nx)."""
        three = (self.state_weights, self.terminal_weights, self.input_weights)
        state, terminal, inputs = (weights if weights.ndim == 2 else np.diag(weights) for weights in three)
        shape = (len(self.input_goal), len(self.state_goal))
        return state, terminal, inputs, np.zeros(shape) if self.cross_weights is None else self.cross_weights

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
        if self.is_full:
            q, last, r, cross = self.matrices()
            x, u, end = state_error[:-1], input_error, state_error[-1]
            stage = 0.5 * ((x @ q * x).sum() + (u @ r * u).sum()) + (u @ cross * x).sum()
            return float(time_step * stage + 0.5 * end @ last @ end)
        stage = (state_error[:-1] ** 2 @ self.state_weights).sum() + (input_error**2 @ self.input_weights).sum()
        return float(0.5 * (time_step * stage + state_error[-1] ** 2 @ self.terminal_weights))


def diagonal(weights: Array) -> Array:
    """Diagonal of weights that are given as a diagonal or as a matrix."""
    return np.diag(weights) if weights.ndim == 2 else weights


def _numbers(name: str, given: object) -> Array:
    """A read-only copy of a vector, or of a matrix of weights."""
    array = np.array(given, dtype=np.float64)
    if not np.isfinite(array).all():
        raise DimensionError("not finite numbers", field=name, given=array.tolist())
    if array.ndim != 1 and not (array.ndim == 2 and name.endswith("weights")):
        raise DimensionError("not a vector of numbers", field=name, given=array.tolist())
    array.flags.writeable = False
    return array


def _check_weights(name: str, weights: Array, size: int) -> None:
    """Check a diagonal or a matrix."""
    if weights.ndim == 2:
        if weights.shape != (size, size):
            raise DimensionError("wrong shape", field=name, given=weights.shape, allowed=str((size, size)))
        if np.abs(weights - weights.T).max(initial=0.0) > 1e-12 * np.abs(weights).max(initial=0.0):
            raise DimensionError("not symmetric", field=name, given=weights.tolist())
        _check_definite(name, weights)
        return
    if len(weights) != size:
        goal = "input_goal" if name == "input_weights" else "state_goal"
        raise DimensionError("wrong length", field=name, given=len(weights), allowed=f"{size}, as many as {goal} has")
    if (weights < 0.0).any():
        raise DimensionError("negative weight", field=name, given=weights.tolist(), allowed=f">= 0 for {name}")


def _check_definite(name: str, matrix: Array) -> None:
    """Check that a symmetric matrix has no negative eigenvalue."""
    values = np.linalg.eigvalsh(matrix)
    scale = np.abs(values).max(initial=0.0)
    if values.min(initial=0.0) < -1e-10 * scale:
        raise DimensionError("negative curvature", field=name, given=values.tolist(), allowed=">= 0")
