"""The door problem for the solvers: quasi-static dynamics with the analytic collision constraints."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.collision.constraints import (
    ConstraintParameters,
    collision_constraints,
    collision_constraints_jacobian,
)
from doorman.compilation import kernel
from doorman.dynamics.quasi_static import (
    ENTRY_COLUMNS,
    ENTRY_ROWS,
    N_ENTRIES,
    QuasiStaticParameters,
    quasi_static_linearize,
    quasi_static_step,
    quasi_static_step_jacobian,
)
from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.numba_types.lanes import get, put, sincos
from doorman.ocp.kernels import functions
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Problem
from doorman.planning.limits import least_cosine, reduced_bounds

Array = NDArray[np.float64]

_PAPER_STATE_WEIGHTS = (5.0, 5.0, 3.0, 9.0, 8.0)
_PAPER_INPUT_WEIGHTS = (0.1, 5.0, 5.0, 13.5)


LANES = 8
"""Nodes that are linearised side by side."""


class DoorModel(NamedTuple):
    """Parameters and memory of the door problem's kernels. Rows: the collision constraints, then the tilt."""

    dynamics: QuasiStaticParameters
    collision: ConstraintParameters
    margin: float
    """Added to the collision constraints [m]."""
    least_cosine: float
    """Of the angle between the body's z axis and the world's."""
    collision_lanes: ConstraintParameters
    """`collision` for nodes side by side."""
    state_lanes: Array
    """(nx, LANES)."""
    input_lanes: Array
    """(nu, LANES)."""
    entry_lanes: Array
    """Of the dynamics' Jacobian, (N_ENTRIES, LANES)."""
    row_lanes: Array
    """(nh, LANES)."""
    slope_lanes: Array
    """(nh, nx, LANES)."""

    @classmethod
    def of(cls, model: Model, disturbance: float) -> DoorModel:
        """Parameters of a scenario's model."""
        planner, nh = model.scenario.planner, model.n_constraints + 1
        return cls(
            dynamics=model.dynamics_parameters(disturbance),
            collision=model.constraint_parameters(),
            margin=planner.margin,
            least_cosine=least_cosine(model),
            collision_lanes=model.constraint_parameters(LANES),
            state_lanes=np.zeros((model.nx, LANES)),
            input_lanes=np.zeros((model.nu, LANES)),
            entry_lanes=np.zeros((N_ENTRIES, LANES)),
            row_lanes=np.zeros((nh, LANES)),
            slope_lanes=np.zeros((nh, model.nx, LANES)),
        )


@functions.implement(functions.step, DoorModel)
@kernel
def _step(model: DoorModel, x: Array, u: Array, out: Array) -> None:
    quasi_static_step(model.dynamics, x, u, out)


@functions.implement(functions.linearize_step, DoorModel)
@kernel
def _linearize_step(model: DoorModel, x: Array, u: Array, jacobian: Array) -> None:
    quasi_static_step_jacobian(model.dynamics, x, u, jacobian)


@functions.implement(functions.constrain, DoorModel)
@kernel
def constrain_door(model: DoorModel, x: Array, h: Array) -> None:
    """Rows of a state: collision constraints with margin, then the tilt, into `h` (nh,)."""
    collision_constraints(model.collision, x, h)
    last = h.shape[0] - 1
    for i in range(last):
        h[i] += model.margin
    _, cr = sincos(x[0])
    _, cp = sincos(x[1])
    h[last] = model.least_cosine - cr * cp


@functions.implement(functions.linearize_constraints, DoorModel)
@kernel
def linearize_door_constraints(model: DoorModel, x: Array, h: Array, jacobian: Array) -> None:
    """The same with their Jacobian into `jacobian` (nh, nx)."""
    jacobian[:, :] = 0.0
    collision_constraints_jacobian(model.collision, x, h, jacobian)
    last = h.shape[0] - 1
    for i in range(last):
        h[i] += model.margin
    sr, cr = sincos(x[0])
    sp, cp = sincos(x[1])
    h[last] = model.least_cosine - cr * cp
    jacobian[last, 0] = sr * cp
    jacobian[last, 1] = cr * sp


@kernel
def _gather(rows: Array, first: int, lanes: Array) -> None:
    """Rows from `first` on into lanes; the last one again where there are no more."""
    last = rows.shape[0] - 1
    for side in range(LANES):
        k = min(first + side, last)
        for i in range(rows.shape[1]):
            lanes[i, side] = rows[k, i]


@functions.implement(functions.linearize_horizon, DoorModel)
@kernel
def linearize_door_horizon(
    model: DoorModel, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    """Dynamics and rows of all nodes, as `functions.linearize_horizon`, many nodes side by side."""
    n, nx, nh = inputs.shape[0], states.shape[1], rows.shape[1]
    lanes, entries, h = model.collision_lanes.arm.lanes, model.entry_lanes, model.dynamics.time_step
    values, slopes, last = model.row_lanes, model.slope_lanes, nh - 1
    for first in range(0, n, LANES):
        _gather(states[:n], first, model.state_lanes)
        _gather(inputs, first, model.input_lanes)
        quasi_static_linearize(model.dynamics, model.state_lanes, model.input_lanes, lanes, entries)
        for side in range(min(LANES, n - first)):
            k = first + side
            for i in range(5):
                jacobians[k, i, nx] = entries[i, side] - states[k + 1, i]
            for i in range(len(ENTRY_ROWS)):
                column = ENTRY_COLUMNS[i]
                jacobians[k, ENTRY_ROWS[i], column if column >= 0 else nx + 5 + column] = entries[5 + i, side]
            jacobians[k, 2, 2] = 1.0
            for i in range(5, nx):
                jacobians[k, i, i] = 1.0
                jacobians[k, i, nx + i] = h
                jacobians[k, i, nx] = states[k, i] + h * inputs[k, i - 1] - states[k + 1, i]
        _gather(states[1:], first, model.state_lanes)
        collision_constraints_jacobian(model.collision_lanes, model.state_lanes, values, slopes)
        sr, cr = sincos(get(model.state_lanes, 0, lanes))
        sp, cp = sincos(get(model.state_lanes, 1, lanes))
        put(values, last, model.least_cosine - cr * cp)
        put(slopes, (last, 0), sr * cp)
        put(slopes, (last, 1), cr * sp)
        for side in range(min(LANES, n - first)):
            k = first + side
            for i in range(nh):
                rows[k, i] = values[i, side] + (model.margin if i < last else 0.0)
                for j in range(nx):
                    row_jacobians[k, i, j] = slopes[i, j, side]


@functions.implement(functions.constrain_horizon, DoorModel)
@kernel
def constrain_door_horizon(model: DoorModel, states: Array, rows: Array) -> None:
    """Rows of all nodes, as `functions.constrain_horizon`, many nodes side by side."""
    n, nh = rows.shape[0], rows.shape[1]
    lanes, values, last = model.collision_lanes.arm.lanes, model.row_lanes, nh - 1
    for first in range(0, n, LANES):
        _gather(states[1:], first, model.state_lanes)
        collision_constraints(model.collision_lanes, model.state_lanes, values)
        _, cr = sincos(get(model.state_lanes, 0, lanes))
        _, cp = sincos(get(model.state_lanes, 1, lanes))
        put(values, last, model.least_cosine - cr * cp)
        for side in range(min(LANES, n - first)):
            for i in range(nh):
                rows[first + side, i] = values[i, side] + (model.margin if i < last else 0.0)


def door_problem(model: Model, disturbance: float = 0.0) -> Problem:
    """Optimal control problem of a scenario: the paper's cost, dynamics and hard constraints.

    Args:
        model: Model of the scenario.
        disturbance: τ_d, torque in the sense of damping, beyond damping, friction and spring [N m].

    Returns:
        The problem, whose constraints are h(x) + planner.margin ≤ 0, the tilt and the bounds of `[limits]`.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
    """
    planner = model.scenario.planner
    return Problem(
        model=DoorModel.of(model, disturbance),
        n_constraints=model.n_constraints + 1,
        integrators=model.n_arm,
        bounds=reduced_bounds(model),
        constraint_names=(*model.constraint_names, "tilt"),
        horizon=planner.horizon_steps,
        time_step=planner.time_step,
        cost=door_cost(model),
    )


def door_cost(model: Model) -> QuadraticCost:
    """The scenario's cost; the paper's weights where it gives none, extended to the arm's joints.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
    """
    weights, n = model.scenario.planner.weights, model.n_arm
    by_joint = ([0.05] + [0.1] * n)[:n]

    def chosen(name: str, given: tuple[float, ...] | None, default: list[float]) -> Array:
        if given is not None and len(given) != len(default):
            field = f"planner.weights.{name}"
            raise ScenarioError(
                "wrong number of weights", file=model.scenario.source, field=field, given=len(given),
                allowed=f"{len(default)} for an arm of {n} joints",
            )  # fmt: skip
        return np.array(default if given is None else given)

    return QuadraticCost(
        state_weights=chosen("state", weights.state, [*_PAPER_STATE_WEIGHTS, *by_joint]),
        terminal_weights=chosen("terminal", weights.terminal, [*_PAPER_STATE_WEIGHTS, *by_joint]),
        input_weights=chosen("input", weights.input, [*_PAPER_INPUT_WEIGHTS, *[10.0] * n]),
        state_goal=model.goal_state,
        input_goal=model.hover_input,
    )
