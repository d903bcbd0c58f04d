"""Memory of one solver: allocated once, so that no iteration allocates."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.function_tables import FunctionTable
from doorman.ocp.kernels import functions
from doorman.ocp.problem.costs import diagonal
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.iterations.filter import Filter
from doorman.ocp.solvers.memory.parts import (
    ActiveSet,
    FlatRows,
    Floors,
    Limits,
    Linearization,
    Multipliers,
    Node,
    Policy,
    Program,
    Settings,
    Sizes,
    Trajectory,
    Weights,
)
from doorman.ocp.solvers.memory.result import Result
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.sweeps.linear_algebra import copy_rows
from doorman.ocp.solvers.sweeps.node_elimination import factors_width
from doorman.ocp.solvers.sweeps.sized import sized_table
from doorman.ocp.solvers.sweeps.tiles import WIDTH

_EARLY = 3.0
"""Rows of early states, on which few inputs act, take so much more of the penalty: multipliers converge there as fast as
elsewhere. Twice as much makes active sets unsettled."""


class Workspace(NamedTuple):
    """Everything that the solvers' kernels read and write."""

    sizes: Sizes
    tiles: FunctionTable
    """What is compiled for these sizes, see `sweeps.sized`."""
    weights: Weights
    settings: Settings
    limits: Limits
    floors: Floors
    nominal: Trajectory
    trial: Trajectory
    saved: Trajectory
    first: Trajectory
    """First guess, for another try."""
    guess: Trajectory
    """First guess of the whole solve, which its result is compared with."""
    multipliers: Multipliers
    proposal: Multipliers
    active: ActiveSet
    linear: Linearization
    policy: Policy
    node: Node
    program: Program
    flat: FlatRows
    stiffness: Array
    """Factor of the penalty of every state's rows and bounds after the first one, (N,)."""
    filter: Filter
    """Of infeasibility and cost."""
    result: Result

    @classmethod
    def of(cls, problem: Problem, options: SolverOptions | None = None) -> Workspace:
        """Workspace for a problem's sizes, with what is compiled for them, or loaded from the cache."""
        plain = cls.plain(problem, options)
        return plain._replace(tiles=sized_table(plain.sizes, plain))

    @classmethod
    def plain(cls, problem: Problem, options: SolverOptions | None = None) -> Workspace:
        """Memory for a problem's sizes; no kernel that calls `tiles` can run on it."""
        n, nx, nu = problem.horizon, problem.nx, problem.nu
        nh, ng, nt = problem.n_constraints, problem.n_input_constraints, problem.n_end_constraints
        narrow, wide = padded(nx + 1), padded(nx + 1 + nu)
        program, stiffness = program_of(problem, wide), 1.0 + _EARLY / np.arange(1.0, n + 1.0)
        chosen = options or SolverOptions()

        def trajectory() -> Trajectory:
            return Trajectory(
                np.zeros((n + 1, nx)), np.zeros((n, nu)), np.zeros((n, nh)), np.zeros((n, ng)), np.zeros(nt)
            )

        def multipliers(kind: Any) -> list[Any]:
            return [np.zeros(shape, dtype=kind) for shape in ((n, nh), (n, ng), (nt,), (n, nx), (n, nu))]

        return cls(
            sizes=sizes_of(problem),
            tiles=FunctionTable(0, []),
            weights=weights_of(problem),
            settings=Settings(
                chosen.tolerance, chosen.feasibility, chosen.penalty, chosen.largest_multiplier, chosen.sweeps,
                int(chosen.guess_active_sets),
            ),
            limits=Limits(*(np.array(each) for each in vars(problem.bounds).values())),
            floors=floors_of(problem),
            nominal=trajectory(),
            trial=trajectory(),
            saved=trajectory(),
            first=trajectory(),
            guess=trajectory(),
            multipliers=Multipliers(*multipliers(np.float64)),
            proposal=Multipliers(*multipliers(np.float64)),
            active=ActiveSet(*multipliers(np.int8), *(np.zeros(n, dtype=np.int64) for _ in range(2))),
            linear=Linearization(
                np.zeros((n, nx, wide)), np.zeros((n, nh, narrow)), np.zeros((n, ng, wide)), np.zeros((nt, narrow))
            ),
            policy=Policy(
                np.zeros((n, nu, narrow)), np.zeros((n, nu, factors_width(nu))),
                np.zeros((n, nx, narrow)), np.zeros(n + 1), np.zeros(n + 1),
            ),
            node=Node(
                np.zeros((nx, narrow)), np.zeros((nx, narrow)), np.zeros((nu, wide)), np.zeros((nu, wide)),
                np.zeros((nu, wide)), np.zeros(wide + 2 * WIDTH), np.zeros((max(nx, nh, ng, nt), nx + nu)),
                np.zeros(nx + nu), np.zeros((nx + nu, nx + nu)),
            ),
            program=program,
            flat=flat_rows_of(problem, program, stiffness),
            stiffness=stiffness,
            filter=Filter(),
            result=Result(pause=np.inf),
        )  # fmt: skip


def padded(length: int) -> int:
    """A length rounded up to whole vectors of `WIDTH`."""
    return -(-length // WIDTH) * WIDTH


def sizes_of(problem: Problem) -> Sizes:
    """Dimensions of a problem."""
    nx, nu, bounds = problem.nx, problem.nu, problem.bounds
    return Sizes(
        states=nx,
        inputs=nu,
        integrators=problem.integrators,
        narrow=padded(nx + 1),
        wide=padded(nx + 1 + nu),
        rows=problem.n_constraints,
        input_rows=problem.n_input_constraints,
        end_rows=problem.n_end_constraints,
        state_bounds=int(_binds(bounds.state_lower, bounds.state_upper)),
        input_bounds=int(_binds(bounds.input_lower, bounds.input_upper)),
        extra_cost=int(functions.has_own_cost(type(problem.model))),
        full_cost=int(problem.cost.is_full),
        equalities=int(any(problem.equalities)),
    )


def _binds(*ends: ArrayLike | None) -> bool:
    return any(np.isfinite(np.asarray(end, dtype=np.float64)).any() for end in ends)


def weights_of(problem: Problem) -> Weights:
    """Copy of a problem's cost, with the weights of states and inputs times Δt."""
    cost, dt = problem.cost, problem.time_step
    off_stage, off_end = np.zeros((0, 0)), np.zeros((0, 0))
    if cost.is_full:
        state, off_end, ahead, cross = (matrix.copy() for matrix in cost.matrices())
        off_stage = dt * np.block([[state, cross.T], [cross, ahead]])
        np.fill_diagonal(off_stage, 0.0)
        np.fill_diagonal(off_end, 0.0)
    inputs = diagonal(cost.input_weights)
    return Weights(
        dt, dt * diagonal(cost.state_weights), diagonal(cost.terminal_weights).copy(),
        dt * inputs, dt * np.where(inputs > 0.0, inputs, 1.0),
        cost.state_goal.copy(), cost.input_goal.copy(), off_stage, off_end,
    )  # fmt: skip


def floors_of(problem: Problem) -> Floors:
    """Least multipliers of a problem's rows: 0, or −∞ of equalities."""
    nh, ng = problem.n_constraints, problem.n_input_constraints
    floors = np.where(np.array(problem.equalities, dtype=bool), -np.inf, 0.0)
    return Floors(floors[:nh].copy(), floors[nh : nh + ng].copy(), floors[nh + ng :].copy())


def program_of(problem: Problem, wide: int) -> Program:
    """Rows of a node's quadratic program, and memory for it."""
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


def flat_rows_of(problem: Problem, program: Program, stiffness: Array) -> FlatRows:
    """Which rows exist at which node, which are equalities, and memory for their numbers."""
    n, nh, ng, nt = problem.horizon, problem.n_constraints, problem.n_input_constraints, problem.n_end_constraints
    first = nh + nt + ng
    applies, factor = np.zeros((n + 1, first + len(program.bounded)), dtype=np.bool_), np.ones((n + 1, 1))
    of_state = np.concatenate([np.arange(first) < nh, program.bounded < problem.nx])
    applies[1:] = of_state
    applies[n, nh : nh + nt] = True
    applies[:n, nh + nt :] |= ~of_state[nh + nt :]
    factor[1:, 0] = stiffness
    given, equal = np.array(problem.equalities, dtype=np.bool_), np.zeros(applies.shape[1], dtype=np.bool_)
    equal[:first] = np.concatenate([given[:nh], given[nh + ng :], given[nh : nh + ng]])
    return FlatRows(applies, equal, np.where(of_state, factor, 1.0), *(np.zeros(applies.shape) for _ in range(3)))


@kernel
def copy_trajectory(source: Trajectory, target: Trajectory) -> None:
    """Copy states, inputs and values of rows."""
    copy_rows(source.states, target.states)
    copy_rows(source.inputs, target.inputs)
    copy_rows(source.rows, target.rows)
    copy_rows(source.input_rows, target.input_rows)
    for i in range(source.end_rows.shape[0]):
        target.end_rows[i] = source.end_rows[i]
