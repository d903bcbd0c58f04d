r"""The door problem with the full Lagrangian dynamics: x = [Φ, α, Φ̇, α̇, H], u = [f_t, T, Ḣ_d].

Constraints and goal are those of the paper's problem. So are the weights of what both models have; the paper's weights of the
body rates, which are inputs there, go to Φ̇, since Ω = W⁻¹(Φ)Φ̇ and W is nearly I at the tilts that are flown. At the last
state Φ̇ has the same weights, as the paper has L = Q. A torque costs per (N m)² what the thrust costs per N²: in flight this
opens the paper's door in 6.2 s; with a tenth of it the plans ask for torques that the rotors do not have, and with ten times as
much they lag behind the door.
"""

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
from doorman.dynamics.lagrangian import (
    LagrangianMemory,
    LagrangianModel,
    LagrangianParameters,
    lagrangian_linearize,
    lagrangian_step,
)
from doorman.dynamics.lagrangian_reduction import reduce_state
from doorman.model import Model
from doorman.numba_types.lanes import get, put, sincos
from doorman.ocp.kernels import functions
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Problem
from doorman.planning.limits import lagrangian_bounds, largest_body_rates, least_cosine
from doorman.planning.weights import chosen_weights

Array = NDArray[np.float64]

_STATE_WEIGHTS = (5.0, 5.0, 3.0, 9.0, 5.0, 5.0, 13.5, 8.0)
_INPUT_WEIGHTS = (0.1, 0.1, 0.1, 0.1)

LANES = 8
"""Nodes that are linearised side by side."""


class LagrangianDoorModel(NamedTuple):
    """Parameters and memory of the problem's kernels. Rows: the collision constraints, the tilt, the body rates."""

    dynamics: LagrangianParameters
    memory_lanes: LagrangianMemory
    """Of the dynamics, for nodes side by side."""
    collision: ConstraintParameters
    collision_lanes: ConstraintParameters
    margin: float
    """Added to the collision constraints [m]."""
    least_cosine: float
    """Of the angle between the body's z axis and the world's."""
    body_rates: Array
    """Largest |Ω|, (3,) [rad/s]; (0,) where they are free."""
    reduced: Array
    """[Φ, α, α̇, H], of which the constraints are functions, (5 + n,)."""
    slopes: Array
    """Their Jacobian by it, (nh, 5 + n)."""
    state_lanes: Array
    """(nx, LANES)."""
    input_lanes: Array
    """(nu, LANES)."""
    entry_lanes: Array
    """The next [q, q̇] and its Jacobian, (8, 13 + 2n, LANES)."""
    row_lanes: Array
    """(nh, LANES)."""
    slope_lanes: Array
    """(nh, 5 + n, LANES)."""

    @classmethod
    def of(cls, model: Model, disturbance: float) -> LagrangianDoorModel:
        """Parameters of a scenario's model."""
        dynamics, nh, n = lagrangian_model(model), model.n_constraints + 1, model.n_arm
        return cls(
            dynamics=dynamics.parameters(disturbance),
            memory_lanes=dynamics.memory(LANES),
            collision=model.constraint_parameters(),
            collision_lanes=model.constraint_parameters(LANES),
            margin=model.scenario.planner.margin,
            least_cosine=least_cosine(model),
            body_rates=largest_body_rates(model),
            reduced=np.zeros(model.nx),
            slopes=np.zeros((nh, model.nx)),
            state_lanes=np.zeros((8 + n, LANES)),
            input_lanes=np.zeros((4 + n, LANES)),
            entry_lanes=np.zeros((8, 13 + 2 * n, LANES)),
            row_lanes=np.zeros((nh, LANES)),
            slope_lanes=np.zeros((nh, model.nx, LANES)),
        )


@functions.implement(functions.step, LagrangianDoorModel)
@kernel
def _step(model: LagrangianDoorModel, x: Array, u: Array, out: Array) -> None:
    lagrangian_step(model.dynamics, x, u, out)


@functions.implement(functions.linearize_step, LagrangianDoorModel)
@kernel
def _linearize_step(model: LagrangianDoorModel, x: Array, u: Array, out: Array) -> None:
    """The same node in every lane: as fast as one alone, and the kernels for lanes are compiled anyway."""
    nx, entries = x.shape[0], model.entry_lanes
    for side in range(LANES):
        for i in range(nx):
            model.state_lanes[i, side] = x[i]
        for i in range(u.shape[0]):
            model.input_lanes[i, side] = u[i]
    lagrangian_linearize(model.dynamics, model.memory_lanes, model.state_lanes, model.input_lanes, entries)
    out[:, :] = 0.0
    for i in range(8):
        for j in range(entries.shape[1] - 1):
            out[i, j] = entries[i, 1 + j, 0]
    for i in range(8, nx):
        out[i, i] = 1.0
        out[i, nx + i - 4] = model.dynamics.time_step


@kernel
def _constrain_body_rates(model: LagrangianDoorModel, x: Array, h: Array) -> None:
    r"""Rows :math:`\pm\Omega - \Omega_{max}` with :math:`\Omega = W^{-1}(\Phi)\dot\Phi`, the last ones of `h`."""
    n = model.body_rates.shape[0]
    if n == 0:
        return
    sr, cr = sincos(x[0])
    sp, cp = sincos(x[1])
    rates = (x[4] - sp * x[6], cr * x[5] + sr * cp * x[6], -sr * x[5] + cr * cp * x[6])
    first = h.shape[0] - 2 * n
    for i in range(n):
        h[first + 2 * i] = rates[i] - model.body_rates[i]
        h[first + 2 * i + 1] = -rates[i] - model.body_rates[i]


@kernel
def _linearize_body_rates(model: LagrangianDoorModel, x: Array, h: Array, jacobian: Array) -> None:
    """The same with slopes; entries that are always zero are not written."""
    n = model.body_rates.shape[0]
    if n == 0:
        return
    _constrain_body_rates(model, x, h)
    sr, cr = sincos(x[0])
    sp, cp = sincos(x[1])
    by_roll = (0.0, -sr * x[5] + cr * cp * x[6], -cr * x[5] - sr * cp * x[6])
    by_pitch = (-cp * x[6], -sr * sp * x[6], -cr * sp * x[6])
    by_rates = ((1.0, 0.0, -sp), (0.0, cr, sr * cp), (0.0, -sr, cr * cp))
    first = h.shape[0] - 2 * n
    for i in range(n):
        for side in range(2):
            row, sign = first + 2 * i + side, 1.0 - 2.0 * side
            jacobian[row, 0], jacobian[row, 1] = sign * by_roll[i], sign * by_pitch[i]
            for j in range(3):
                jacobian[row, 4 + j] = sign * by_rates[i][j]


@functions.implement(functions.constrain, LagrangianDoorModel)
@kernel
def _constrain(model: LagrangianDoorModel, x: Array, h: Array) -> None:
    reduce_state(x, model.reduced)
    last = model.slopes.shape[0] - 1
    collision_constraints(model.collision, model.reduced, h[: last + 1])
    _constrain_body_rates(model, x, h)
    for i in range(last):
        h[i] += model.margin
    _, cr = sincos(x[0])
    _, cp = sincos(x[1])
    h[last] = model.least_cosine - cr * cp


@functions.implement(functions.linearize_constraints, LagrangianDoorModel)
@kernel
def _linearize_constraints(model: LagrangianDoorModel, x: Array, h: Array, jacobian: Array) -> None:
    slopes, last = model.slopes, model.slopes.shape[0] - 1
    reduce_state(x, model.reduced)
    collision_constraints_jacobian(model.collision, model.reduced, h[: last + 1], slopes)
    jacobian[last + 1 :, :] = 0.0
    _linearize_body_rates(model, x, h, jacobian)
    sr, cr = sincos(x[0])
    sp, cp = sincos(x[1])
    h[last] = model.least_cosine - cr * cp
    slopes[last, 0], slopes[last, 1] = sr * cp, cr * sp
    for i in range(last + 1):
        h[i] += model.margin if i < last else 0.0
        for j in range(4):
            jacobian[i, j] = slopes[i, j]
            jacobian[i, 4 + j] = 0.0
        for j in range(8, x.shape[0]):
            jacobian[i, j] = slopes[i, j - 3]


@kernel
def _gather(rows: Array, first: int, lanes: Array) -> None:
    """Rows from `first` on into lanes; the last one again where there are no more."""
    last = rows.shape[0] - 1
    for side in range(LANES):
        k = min(first + side, last)
        for i in range(rows.shape[1]):
            lanes[i, side] = rows[k, i]


@kernel
def _gather_reduced(states: Array, first: int, lanes: Array) -> None:
    """The same, reduced."""
    last = states.shape[0] - 1
    for side in range(LANES):
        k = min(first + side, last)
        for i in range(lanes.shape[0]):
            lanes[i, side] = states[k, i if i < 4 else i + 3]


@functions.implement(functions.linearize_horizon, LagrangianDoorModel)
@kernel
def _linearize_horizon(
    model: LagrangianDoorModel, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    n, nx, nu, nh = inputs.shape[0], states.shape[1], inputs.shape[1], model.slopes.shape[0]
    lanes, entries, h = model.collision_lanes.arm.lanes, model.entry_lanes, model.dynamics.time_step
    values, slopes, last, reduced = model.row_lanes, model.slope_lanes, nh - 1, model.state_lanes[: nx - 3]
    for first in range(0, n, LANES):
        _gather(states[:n], first, model.state_lanes)
        _gather(inputs, first, model.input_lanes)
        lagrangian_linearize(model.dynamics, model.memory_lanes, model.state_lanes, model.input_lanes, entries)
        for side in range(min(LANES, n - first)):
            k = first + side
            for i in range(8):
                jacobians[k, i, nx] = entries[i, 0, side] - states[k + 1, i]
                for j in range(nx):
                    jacobians[k, i, j] = entries[i, 1 + j, side]
                for j in range(nu):
                    jacobians[k, i, nx + 1 + j] = entries[i, 1 + nx + j, side]
            for i in range(8, nx):
                jacobians[k, i, i] = 1.0
                jacobians[k, i, nx + i - 3] = h
                jacobians[k, i, nx] = states[k, i] + h * inputs[k, i - 4] - states[k + 1, i]
        _gather_reduced(states[1:], first, reduced)
        collision_constraints_jacobian(model.collision_lanes, reduced, values, slopes)
        sr, cr = sincos(get(reduced, 0, lanes))
        sp, cp = sincos(get(reduced, 1, lanes))
        put(values, last, model.least_cosine - cr * cp)
        put(slopes, (last, 0), sr * cp)
        put(slopes, (last, 1), cr * sp)
        for side in range(min(LANES, n - first)):
            k = first + side
            for i in range(nh):
                rows[k, i] = values[i, side] + (model.margin if i < last else 0.0)
                for j in range(4):
                    row_jacobians[k, i, j] = slopes[i, j, side]
                for j in range(8, nx):
                    row_jacobians[k, i, j] = slopes[i, j - 3, side]
            _linearize_body_rates(model, states[k + 1], rows[k], row_jacobians[k])


@functions.implement(functions.constrain_horizon, LagrangianDoorModel)
@kernel
def _constrain_horizon(model: LagrangianDoorModel, states: Array, rows: Array) -> None:
    n, nh = rows.shape[0], model.slopes.shape[0]
    lanes, values, last = model.collision_lanes.arm.lanes, model.row_lanes, nh - 1
    reduced = model.state_lanes[: states.shape[1] - 3]
    for first in range(0, n, LANES):
        _gather_reduced(states[1:], first, reduced)
        collision_constraints(model.collision_lanes, reduced, values)
        _, cr = sincos(get(reduced, 0, lanes))
        _, cp = sincos(get(reduced, 1, lanes))
        put(values, last, model.least_cosine - cr * cp)
        for side in range(min(LANES, n - first)):
            for i in range(nh):
                rows[first + side, i] = values[i, side] + (model.margin if i < last else 0.0)
            _constrain_body_rates(model, states[first + side + 1], rows[first + side])


def lagrangian_problem(model: Model, disturbance: float = 0.0) -> Problem:
    """Optimal control problem of a scenario with the full dynamics.

    Args:
        model: Model of the scenario.
        disturbance: τ_d, torque in the sense of damping, beyond damping, friction and spring [N m].

    Returns:
        The problem, whose constraints are h(x) + planner.margin ≤ 0, the tilt, the body rates and the bounds of `[limits]`.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
    """
    planner, parameters = model.scenario.planner, LagrangianDoorModel.of(model, disturbance)
    rates = tuple(f"{name} {end}" for name in ("roll rate", "pitch rate", "yaw rate") for end in ("above", "below"))
    limited = rates if parameters.body_rates.size else ()
    return Problem(
        model=parameters,
        n_constraints=model.n_constraints + 1 + len(limited),
        bounds=lagrangian_bounds(model),
        constraint_names=(*model.constraint_names, "tilt", *limited),
        horizon=planner.horizon_steps,
        time_step=planner.time_step,
        cost=lagrangian_cost(model),
    )


def lagrangian_model(model: Model) -> LagrangianModel:
    """Full dynamics of a scenario; I_A is that of the goal's posture.

    Args:
        model: Model of the scenario.
    """
    return LagrangianModel(model.coupling, model.scenario.planner.time_step, inertia_posture=model.goal_arm)


def lagrangian_cost(model: Model) -> QuadraticCost:
    """The scenario's cost; the weights above where it gives none, extended to the arm's joints.

    Args:
        model: Model of the scenario.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
    """
    n = model.n_arm
    by_state = [*_STATE_WEIGHTS, *([0.05] + [0.1] * n)[:n]]
    return QuadraticCost(
        state_weights=chosen_weights(model, "state", by_state),
        terminal_weights=chosen_weights(model, "terminal", by_state),
        input_weights=chosen_weights(model, "input", [*_INPUT_WEIGHTS, *[10.0] * n]),
        state_goal=at_rest(model.goal_state),
        input_goal=model.hover_input,
    )


def at_rest(reduced: Array) -> Array:
    """State of the full dynamics with Φ̇ = 0.

    Args:
        reduced: [Φ, α, α̇, H], shape (5 + n,).

    Returns:
        [Φ, α, Φ̇, α̇, H], shape (8 + n,).
    """
    return np.concatenate([reduced[:4], np.zeros(3), reduced[4:]])
