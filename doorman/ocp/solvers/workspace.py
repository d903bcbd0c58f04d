"""Memory of one solver: allocated once, so that no iteration allocates."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.compilation import kernel
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows
from doorman.ocp.solvers.sweeps.node_elimination import factors_width

Array = NDArray[np.float64]
Sides = NDArray[np.int8]

VECTOR_WIDTH = 8
"""Doubles in the widest vector register; rows are padded to a multiple of it."""

LARGEST_STATE = 1e6
"""A trajectory with a larger number in a state has diverged."""

_EARLY = 3.0
"""Rows of early states, on which few inputs act, take so much more of the penalty: multipliers converge there as fast as
elsewhere. Twice as much makes active sets unsettled."""

FILTER_SIZE = 32
"""Pairs of cost and infeasibility that a line search remembers."""


class Sizes(NamedTuple):
    """Dimensions as lengths of tuples: part of the type, so that kernels are compiled for them and unroll their loops."""

    states: tuple[int, ...]
    inputs: tuple[int, ...]
    integrators: tuple[int, ...]
    rows: tuple[int, ...]
    """Rows of h."""
    input_rows: tuple[int, ...]
    """Rows of g."""
    end_rows: tuple[int, ...]
    """Rows of h_N."""
    state_bounds: tuple[int, ...]
    """nx if any state is bounded, else 0."""
    input_bounds: tuple[int, ...]
    """nu if any input is bounded, else 0."""
    extra_cost: tuple[int, ...]
    """1 if the model has a cost of its own, else 0."""
    narrow: tuple[int, ...]
    """nx + 1, padded."""
    wide: tuple[int, ...]
    """nx + 1 + nu, padded."""


class Weights(NamedTuple):
    """The quadratic cost for kernels; stage weights already times Δt."""

    time_step: float
    state: Array
    terminal: Array
    input: Array
    state_goal: Array
    input_goal: Array


class Settings(NamedTuple):
    """Settings of the augmented Lagrangian's kernels, see `SolverOptions`."""

    tolerance: float
    penalty: float
    largest_multiplier: float
    sweeps: int


class Limits(NamedTuple):
    """Bounds for kernels, as in `Bounds`."""

    state_lower: Array
    state_upper: Array
    input_lower: Array
    input_upper: Array


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
    """Of the constraints, not negative; those of bounds are negative at the lower end."""

    rows: Array
    input_rows: Array
    end_rows: Array
    states: Array
    """Of the bounds at nodes 1 … N, (N, nx)."""
    inputs: Array
    """(N, nu)."""


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
    sums: Array
    """Of the nodes from k on: twice the predicted decrease of the cost, and the largest |V_x|, (N + 1, 2)."""


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


class Workspace(NamedTuple):
    """Everything that the solvers' kernels read and write."""

    sizes: Sizes
    weights: Weights
    settings: Settings
    limits: Limits
    nominal: Trajectory
    trial: Trajectory
    saved: Trajectory
    first: Trajectory
    """First guess, for another try."""
    multipliers: Multipliers
    proposal: Multipliers
    active: ActiveSet
    linear: Linearization
    policy: Policy
    node: Node
    program: Program
    stiffness: Array
    """Factor of the penalty of every state's rows and bounds after the first one, (N,)."""
    filter: Array
    """Pairs of infeasibility and cost, (FILTER_SIZE, 2)."""
    result: Array
    """Scalars out, see `Result`."""

    @classmethod
    def of(cls, problem: Problem, options: SolverOptions | None = None) -> Workspace:
        """Allocate for a problem's sizes."""
        n, nx, nu = problem.horizon, problem.nx, problem.nu
        nh, ng, nt = problem.n_constraints, problem.n_input_constraints, problem.n_end_constraints
        narrow, wide = padded(nx + 1), padded(nx + 1 + nu)
        chosen = options or SolverOptions()

        def trajectory() -> Trajectory:
            return Trajectory(
                np.zeros((n + 1, nx)), np.zeros((n, nu)), np.zeros((n, nh)), np.zeros((n, ng)), np.zeros(nt)
            )

        def multipliers(kind: Any) -> list[Any]:
            return [np.zeros(shape, dtype=kind) for shape in ((n, nh), (n, ng), (nt,), (n, nx), (n, nu))]

        return cls(
            sizes=sizes_of(problem),
            weights=weights_of(problem),
            settings=Settings(chosen.tolerance, chosen.penalty, chosen.largest_multiplier, chosen.sweeps),
            limits=Limits(*(np.array(each) for each in vars(problem.bounds).values())),
            nominal=trajectory(),
            trial=trajectory(),
            saved=trajectory(),
            first=trajectory(),
            multipliers=Multipliers(*multipliers(np.float64)),
            proposal=Multipliers(*multipliers(np.float64)),
            active=ActiveSet(*multipliers(np.int8), *(np.zeros(n, dtype=np.int64) for _ in range(2))),
            linear=Linearization(
                np.zeros((n, nx, wide)), np.zeros((n, nh, narrow)), np.zeros((n, ng, wide)), np.zeros((nt, narrow))
            ),
            policy=Policy(
                np.zeros((n, nu, narrow)), np.zeros((n, nu, factors_width(nu))),
                np.zeros((n, nx, narrow)), np.zeros((n + 1, 2)),
            ),
            node=Node(
                np.zeros((nx, narrow)), np.zeros((nx, narrow)), np.zeros((nu, wide)), np.zeros((nu, wide)),
                np.zeros((nu, wide)), np.zeros(wide + 2 * VECTOR_WIDTH), np.zeros((max(nx, nh, ng, nt), nx + nu)),
                np.zeros(nx + nu), np.zeros((nx + nu, nx + nu)),
            ),
            program=program_of(problem, wide),
            stiffness=1.0 + _EARLY / np.arange(1.0, n + 1.0),
            filter=np.zeros((FILTER_SIZE, 2)),
            result=np.zeros(len(Result._fields)),
        )  # fmt: skip


class Result(NamedTuple):
    """Positions in `Workspace.result`."""

    COST: int = 0
    """J of the trajectory that was evaluated last."""
    ITERATIONS: int = 1
    DECREASE: int = 2
    """Decrease of the cost that the last sweep predicts."""
    CHANGE: int = 3
    """Largest change of an input by the last sweep, weighted by its cost."""
    DEFECT: int = 4
    """Largest |e|."""
    VIOLATION: int = 5
    """Largest violated row or bound."""
    INFEASIBILITY: int = 6
    """Sum of defects and violations."""
    NODE: int = 7
    """Node at which a kernel stopped, or where the worst violation is."""
    ROW: int = 8
    """Row of the worst violation, numbered as in `Program`."""
    ENTRIES: int = 9
    """Number of pairs in the filter."""
    PENALTY: int = 10
    """1/μ with which the fast iterations ended."""
    RELAXED: int = 11
    """Nodes at which no input was good enough for all rows."""
    CORRECTIONS: int = 12
    """Corrections that the node had had where a rollout stopped."""
    PRICED_OUT: int = 13
    """1 if a multiplier has reached its largest value."""
    SETTLED: int = 14
    """1 if the last step fits the active set that it was found with."""
    COSTATE: int = 15
    """Largest entry of V_x in the last sweep."""
    SWEEPS: int = 16
    """Riccati sweeps since this was last set to zero."""
    PRICE: int = 17
    """What the last change of the multipliers was worth, in units of the cost."""
    NEAR: int = 18
    """1 while derivatives along the nominal trajectory are good enough for a rollout's first corrections."""
    STRAIGHT: int = 19
    """1 if the first guess was the straight line."""
    EXPECTED: int = 20
    """J of what the iterations ended with, before it was rolled out."""
    ROLLOUT_TIME: int = 21
    """Duration of the last rollout [s]."""


RESULT = Result()


def padded(length: int) -> int:
    """A length rounded up to whole vectors."""
    return -(-length // VECTOR_WIDTH) * VECTOR_WIDTH


def sizes_of(problem: Problem) -> Sizes:
    """Dimensions of a problem."""
    nx, nu, bounds, model = problem.nx, problem.nu, problem.bounds, type(problem.model)
    own_cost = functions.is_implemented(functions.stage_cost, model) or functions.is_implemented(
        functions.end_cost, model
    )
    lengths = {
        "states": nx,
        "inputs": nu,
        "integrators": problem.integrators,
        "rows": problem.n_constraints,
        "input_rows": problem.n_input_constraints,
        "end_rows": problem.n_end_constraints,
        "state_bounds": nx * _binds(bounds.state_lower, bounds.state_upper),
        "input_bounds": nu * _binds(bounds.input_lower, bounds.input_upper),
        "extra_cost": int(own_cost),
        "narrow": padded(nx + 1),
        "wide": padded(nx + 1 + nu),
    }
    return Sizes(**{name: (0,) * length for name, length in lengths.items()})


def _binds(*ends: ArrayLike | None) -> bool:
    return any(np.isfinite(np.asarray(end, dtype=np.float64)).any() for end in ends)


def weights_of(problem: Problem) -> Weights:
    """Copy of a problem's cost."""
    cost = problem.cost
    return Weights(
        time_step=problem.time_step,
        state=cost.state_weights * problem.time_step,
        terminal=cost.terminal_weights.copy(),
        input=cost.input_weights * problem.time_step,
        state_goal=cost.state_goal.copy(),
        input_goal=cost.input_goal.copy(),
    )


def program_of(problem: Problem, wide: int) -> Program:
    """Rows of a node's program and memory for it."""
    n, nx, nu, bounds = problem.horizon, problem.nx, problem.nu, problem.bounds
    found = []
    for kind, first, size in (("state", 0, nx), ("input", nx, nu)):
        for i in range(size):
            for end, side in (("upper", 1.0), ("lower", -1.0)):
                limit = float(np.asarray(getattr(bounds, f"{kind}_{end}"))[i])
                if np.isfinite(limit):
                    found.append((first + i, side, limit))
    general = problem.n_constraints + problem.n_end_constraints + problem.n_input_constraints
    rows, most = general + len(found), nu + 1
    return Program(
        hessian=np.zeros((nu, nu)),
        gradient=np.zeros(nu),
        jacobian=np.zeros((rows, nu)),
        constraints=np.zeros(rows),
        step=np.zeros(nu),
        multipliers=np.zeros(rows),
        bounded=np.array([index for index, _, _ in found], dtype=np.int64),
        side=np.array([side for _, side, _ in found], dtype=np.float64),
        limit=np.array([limit for _, _, limit in found], dtype=np.float64),
        active=np.zeros((n, rows), dtype=np.bool_),
        eliminated=np.zeros((rows, wide)),
        projected=np.zeros((rows, nu)),
        gathered=np.zeros((most, most)),
        indices=np.zeros(rows, dtype=np.int64),
        proposal=np.zeros(rows, dtype=np.bool_),
        residuals=np.zeros(rows),
        dual=np.zeros((most, wide)),
        scratch=np.zeros((problem.n_constraints + problem.n_end_constraints) * nx),
    )


@kernel
def copy_trajectory(source: Trajectory, target: Trajectory) -> None:
    """Copy a trajectory."""
    copy_rows(source.states, target.states)
    copy_rows(source.inputs, target.inputs)
    copy_rows(source.rows, target.rows)
    copy_rows(source.input_rows, target.input_rows)
    for i in range(source.end_rows.shape[0]):
        target.end_rows[i] = source.end_rows[i]
