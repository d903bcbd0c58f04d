"""Parts of a solver's memory: sizes, weights and limits, trajectories, multipliers, derivatives, policies, one node's program."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array

Sides = NDArray[np.int8]


class Sizes(NamedTuple):
    """Dimensions: numbers, so that one set of kernels serves all problems; see `sized` for those that are compiled for them."""

    states: int
    inputs: int
    integrators: int
    narrow: int
    """nx + 1, padded."""
    wide: int
    """nx + 1 + nu, padded."""
    rows: int
    """Rows of h."""
    input_rows: int
    """Rows of g."""
    end_rows: int
    """Rows of h_N."""
    state_bounds: int
    """1 if any state is bounded, else 0."""
    input_bounds: int
    """1 if any input is bounded, else 0."""
    extra_cost: int
    """1 if the model has a cost of its own, else 0."""
    full_cost: int
    """1 if the quadratic cost has more than diagonals, else 0."""
    equalities: int
    """1 if a row is an equality, else 0."""


class Weights(NamedTuple):
    """The quadratic cost for kernels; stage weights already times Δt."""

    time_step: float
    state: Array
    terminal: Array
    input: Array
    metric: Array
    """The same, and Δt where an input has no weight: what regularisation and changes of inputs are measured with."""
    state_goal: Array
    input_goal: Array
    off_stage: Array
    """[Q Sᵀ; S R] Δt without its diagonal, (nx + nu, nx + nu); without full matrices this and the next are empty."""
    off_end: Array
    """L without its diagonal, (nx, nx)."""


class Settings(NamedTuple):
    """Settings of the augmented Lagrangian's kernels, see `SolverOptions`."""

    tolerance: float
    feasibility: float
    penalty: float
    largest_multiplier: float
    sweeps: int
    guess_active_sets: int
    """1 if a node's program is tried without ProxQP first, else 0."""


class Limits(NamedTuple):
    """Bounds for kernels, as in `Bounds`."""

    state_lower: Array
    state_upper: Array
    input_lower: Array
    input_upper: Array


class Floors(NamedTuple):
    """Least multipliers of rows: 0 of h ≤ 0, −inf of h = 0."""

    rows: Array
    """(nh,)."""
    input_rows: Array
    """(ng,)."""
    end_rows: Array
    """(nt,)."""


class Trajectory(NamedTuple):
    """States, inputs and the values of the constraints along them."""

    states: Array
    """(N + 1, nx)."""
    inputs: Array
    """(N, nu)."""
    rows: Array
    """h at nodes 1 … N, (N, nh)."""
    input_rows: Array
    """g at nodes 0 … N − 1, (N, ng)."""
    end_rows: Array
    """h_N, (nt,)."""


class Multipliers(NamedTuple):
    r"""Prices of constraints and bounds.

    The Lagrangian is :math:`J + \sum \lambda^T h + \sum \nu (v - \text{bound})`. λ ≥ 0 belongs to h ≤ 0 as the solver sees it,
    divided by its scale; λ of either sign to h = 0. ν > 0 belongs to an upper bound, ν < 0 to a lower one. They have these signs
    in CasADi and IPOPT, too. Relaxing a row by 1 of its (scaled) unit lowers J by λ. J has Δt in it, and so have they.
    """

    rows: Array
    """Multipliers of h at nodes 1 … N, (N, nh)."""
    input_rows: Array
    """Multipliers of g at nodes 0 … N − 1, (N, ng)."""
    end_rows: Array
    """Multipliers of h_N, (nt,)."""
    states: Array
    """Multipliers of the bounds at nodes 1 … N, (N, nx)."""
    inputs: Array
    """Multipliers of the bounds at nodes 0 … N − 1, (N, nu)."""


class ActiveSet(NamedTuple):
    """What the present sweep takes for active: 1, or −1 at a lower bound."""

    rows: Sides
    input_rows: Sides
    end_rows: Sides
    states: Sides
    inputs: Sides
    state_count: NDArray[np.int64]
    """Active rows and bounds of state k + 1, (N,)."""
    input_count: NDArray[np.int64]
    """Active rows and bounds of input k, (N,)."""


class Linearization(NamedTuple):
    """Derivatives along the nominal trajectory, rows padded."""

    jacobians: Array
    """[A | e | B], (N, nx, wide)."""
    row_jacobians: Array
    """[h_x | ·], (N, nh, narrow)."""
    input_row_jacobians: Array
    """[g_x | · | g_u], (N, ng, wide)."""
    end_row_jacobians: Array
    """[h_x | ·], (nt, narrow)."""


class Policy(NamedTuple):
    """What a sweep leaves behind for every node."""

    gains: Array
    """[K | k], (N, nu, narrow): δu = K δx + k."""
    factors: Array
    """U of Q_uu = Uᵀ D U with D on the diagonal, (N, nu, padded nu)."""
    values: Array
    """[V_xx | V_x] without the penalties of state k, (N, nx, narrow)."""
    decreases: Array
    """Twice the predicted decrease of the cost by the nodes from k on, (N + 1,)."""
    costates: Array
    """Largest |V_x| of the nodes from k on, (N + 1,)."""


class Node(NamedTuple):
    """Intermediate results of one node."""

    value: Array
    """[V_xx | V_x], (nx, narrow)."""
    base_x: Array
    """[Q_xx | Q_x] of the cost, (nx, narrow)."""
    base_u: Array
    """[Q_ux | Q_u | Q_uu] of the cost, (nu, wide)."""
    rows: Array
    """R of the elimination, (nu, wide)."""
    scaled: Array
    """L of the elimination, (nu, wide)."""
    step: Array
    """[δx | 1 | δu], (wide + padding,)."""
    plain: Array
    """A Jacobian before it is padded, (max(nx, nh, ng, nt), nx + nu)."""
    gradient: Array
    """(nx + nu,)."""
    hessian: Array
    """(nx + nu, nx + nu)."""


class FlatRows(NamedTuple):
    """Rows and bounds of all nodes, numbered as in `Program`, those of a state at its own node; see `sweeps.flat_rows`."""

    applies: NDArray[np.bool_]
    """Whether a row exists at a node, (N + 1, rows)."""
    equal: NDArray[np.bool_]
    """Which rows are equalities, (rows,)."""
    stiffness: Array
    """Factor of the penalty of every row, (N + 1, rows)."""
    values: Array
    """(N + 1, rows), as the next two."""
    others: Array
    """Values along another trajectory."""
    prices: Array
    """Multipliers, of bounds with their signs."""


class Program(NamedTuple):
    """One node's quadratic program min ½ vᵀHv + gᵀv subject to c + D v ≤ 0, and its solution.

    Its rows: h of the next state, h_N where it is the last, g, then one for every finite bound of states and inputs.
    """

    hessian: Array
    gradient: Array
    jacobian: Array
    """D, (rows, nu)."""
    constraints: Array
    """c, (rows,)."""
    step: Array
    multipliers: Array
    bounded: NDArray[np.int64]
    """Index of the state, or nx + index of the input, of every bound's row."""
    side: Array
    """1 for an upper bound's row, −1 for a lower one's."""
    limit: Array
    """The bound of the row."""
    active: NDArray[np.bool_]
    """Active rows of all nodes, (N, rows)."""
    eliminated: Array
    """[C A | c | C B] of every row, its input part eliminated, (rows, wide)."""
    projected: Array
    """T with D = T U, (rows, nu)."""
    gathered: Array
    """Factor of the active rows' Schur complement, (nu + 1, nu + 1)."""
    indices: NDArray[np.int64]
    """Rows of the active set, (rows,)."""
    proposal: NDArray[np.bool_]
    """(rows,)."""
    residuals: Array
    """(rows,)."""
    dual: Array
    """(nu + 1, wide)."""
    scratch: Array
    """Jacobians of rows, ((nh + nt) nx,)."""
