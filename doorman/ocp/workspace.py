"""Memory of one CDDP solver: allocated once, so that no iteration allocates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.ocp.problem import Problem

Array = NDArray[np.float64]

VECTOR_WIDTH = 8
"""Doubles in the widest vector register."""


class Weights(NamedTuple):
    """The quadratic cost for kernels; stage weights already times Δt."""

    state: Array
    terminal: Array
    input: Array
    state_goal: Array
    input_goal: Array

    @classmethod
    def of(cls, problem: Problem) -> Weights:
        """Copy of a problem's cost."""
        cost = problem.cost
        return cls(
            state=cost.state_weights * problem.time_step,
            terminal=cost.terminal_weights.copy(),
            input=cost.input_weights * problem.time_step,
            state_goal=cost.state_goal.copy(),
            input_goal=cost.input_goal.copy(),
        )


class Trajectory(NamedTuple):
    """States and inputs that the solver works on."""

    states: Array
    """(N + 1, nx)."""
    inputs: Array
    """(N, nu)."""
    constraints: Array
    """h at nodes 1 … N, (N, nh)."""


class Policy(NamedTuple):
    """Linearisation, and what the backward pass leaves behind for every node; rows are padded to the vector width."""

    jacobians: Array
    """[A | B | defect], (N, nx, width)."""
    constraint_jacobians: Array
    """∂h/∂x at nodes 1 … N, (N, nh, nx)."""
    gains: Array
    """[K | · | k], (N, nu, width): δu = K δx + k."""
    factors: Array
    """Cholesky factor L of Q_uu, (N, nu, nu)."""
    multipliers: Array
    """(N, nh)."""
    active: NDArray[np.bool_]
    """(N, nh)."""


class StageQp(NamedTuple):
    """One node's quadratic program min ½ vᵀHv + gᵀv subject to h + D v ≤ 0, and its solution."""

    hessian: Array
    gradient: Array
    jacobian: Array
    constraints: Array
    step: Array
    multipliers: Array


class Scratch(NamedTuple):
    """Intermediate results of one node; rows are padded to the vector width."""

    value: Array
    """[V_xx | · | V_x], (nx, width)."""
    product: Array
    """V_xx [A | B | defect], plus V_x in the last column, (nx, width)."""
    hessian: Array
    """[Q_zx | Q_zu | Q_z], (nx + nu, width)."""
    half: Array
    """L⁻¹ [Q_ux | Q_uu | Q_u] = [Y | Lᵀ | y], (nu, width)."""
    half_constrained: Array
    """The same with the active rows' part, (nu, width)."""
    rows: Array
    """C[A | B | defect] with h in the last column, less T times `half`, (nh, width)."""
    projected: Array
    """T = D L⁻ᵀ, (nh, nu)."""
    schur: Array
    schur_factor: Array
    """(nh, nh)."""
    dual: Array
    """(nh, width)."""
    residuals: Array
    """(nh,)."""
    indices: NDArray[np.int64]
    """Rows of the active set, (nh,)."""
    proposal: NDArray[np.bool_]
    """(nh,)."""
    linearization: Array
    """(nx, width)."""
    constraint_jacobian: Array
    """(nh, nx)."""
    result: Array
    """Scalars out: cost, violation, predicted decrease, stationarity."""


class Sizes(NamedTuple):
    """Dimensions as lengths of tuples: part of the type, so that kernels are compiled for them and unroll their loops."""

    states: tuple[int, ...]
    inputs: tuple[int, ...]
    constraints: tuple[int, ...]
    width: tuple[int, ...]
    """nx + nu + 1, rounded up to a multiple of the vector width."""


class Workspace(NamedTuple):
    """Everything that the solvers' kernels read and write."""

    sizes: Sizes
    weights: Weights
    nominal: Trajectory
    trial: Trajectory
    policy: Policy
    qp: StageQp
    scratch: Scratch

    @classmethod
    def of(cls, problem: Problem) -> Workspace:
        """Allocate for a problem's sizes."""
        n, nx, nu, nh = problem.horizon, problem.nx, problem.nu, problem.n_constraints
        width = -(-(nx + nu + 1) // VECTOR_WIDTH) * VECTOR_WIDTH

        def trajectory() -> Trajectory:
            return Trajectory(np.zeros((n + 1, nx)), np.zeros((n, nu)), np.zeros((n, nh)))

        return cls(
            sizes=Sizes((0,) * nx, (0,) * nu, (0,) * nh, (0,) * width),
            weights=Weights.of(problem),
            nominal=trajectory(),
            trial=trajectory(),
            policy=Policy(
                np.zeros((n, nx, width)), np.zeros((n, nh, nx)), np.zeros((n, nu, width)), np.zeros((n, nu, nu)),
                np.zeros((n, nh)), np.zeros((n, nh), dtype=np.bool_),
            ),
            qp=StageQp(
                np.zeros((nu, nu)), np.zeros(nu), np.zeros((nh, nu)), np.zeros(nh), np.zeros(nu), np.zeros(nh)
            ),
            scratch=Scratch(
                np.zeros((nx, width)), np.zeros((nx, width)), np.zeros((nx + nu, width)), np.zeros((nu, width)),
                np.zeros((nu, width)), np.zeros((nh, width)), np.zeros((nh, nu)), np.zeros((nh, nh)),
                np.zeros((nh, nh)), np.zeros((nh, width)), np.zeros(nh), np.zeros(nh, dtype=np.int64),
                np.zeros(nh, dtype=np.bool_), np.zeros((nx, width)), np.zeros((nh, nx)), np.zeros(4),
            ),
        )  # fmt: skip

    def swapped(self) -> Workspace:
        """The same memory with nominal and trial trajectory exchanged."""
        return self._replace(nominal=self.trial, trial=self.nominal)
