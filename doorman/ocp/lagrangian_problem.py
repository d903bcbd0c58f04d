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
from doorman.dynamics.lagrangian import LagrangianModel, LagrangianParameters, lagrangian_step, lagrangian_step_jacobian
from doorman.dynamics.lagrangian_reduction import reduce_state
from doorman.model import Model
from doorman.ocp import functions
from doorman.ocp.costs import QuadraticCost
from doorman.ocp.limits import lagrangian_bounds
from doorman.ocp.problem import Problem
from doorman.ocp.weights import chosen_weights

Array = NDArray[np.float64]

_STATE_WEIGHTS = (5.0, 5.0, 3.0, 9.0, 5.0, 5.0, 13.5, 8.0)
_INPUT_WEIGHTS = (0.1, 0.1, 0.1, 0.1)


class LagrangianDoorModel(NamedTuple):
    """Parameters of the problem's kernels."""

    dynamics: LagrangianParameters
    collision: ConstraintParameters
    margin: float
    reduced: Array
    """Scratch: [Φ, α, α̇, H], of which the constraints are functions, shape (5 + n,)."""
    slopes: Array
    """Scratch: their Jacobian by it, shape (nh, 5 + n)."""


@functions.implement(functions.step, LagrangianDoorModel)
@kernel
def _step(model: LagrangianDoorModel, x: Array, u: Array, out: Array) -> None:
    lagrangian_step(model.dynamics, x, u, out)


@functions.implement(functions.linearize_step, LagrangianDoorModel)
@kernel
def _linearize_step(model: LagrangianDoorModel, x: Array, u: Array, out: Array) -> None:
    lagrangian_step_jacobian(model.dynamics, x, u, out)


@functions.implement(functions.constrain, LagrangianDoorModel)
@kernel
def _constrain(model: LagrangianDoorModel, x: Array, h: Array) -> None:
    reduce_state(x, model.reduced)
    collision_constraints(model.collision, model.reduced, h)
    for i in range(h.shape[0]):
        h[i] += model.margin


@functions.implement(functions.linearize_constraints, LagrangianDoorModel)
@kernel
def _linearize_constraints(model: LagrangianDoorModel, x: Array, h: Array, jacobian: Array) -> None:
    slopes = model.slopes
    reduce_state(x, model.reduced)
    collision_constraints_jacobian(model.collision, model.reduced, h, slopes)
    for i in range(h.shape[0]):
        h[i] += model.margin
        for j in range(4):
            jacobian[i, j] = slopes[i, j]
            jacobian[i, 4 + j] = 0.0
        for j in range(8, x.shape[0]):
            jacobian[i, j] = slopes[i, j - 3]


def lagrangian_problem(model: Model, disturbance: float = 0.0) -> Problem:
    """Optimal control problem of a scenario with the full dynamics.

    Args:
        model: Model of the scenario.
        disturbance: τ_d, torque in the sense of damping, beyond damping, friction and spring [N m].

    Returns:
        The problem, whose constraints are h(x) + planner.margin ≤ 0 and the bounds of `[limits]`.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
    """
    planner = model.scenario.planner
    return Problem(
        model=LagrangianDoorModel(
            dynamics=lagrangian_model(model).parameters(disturbance),
            collision=model.constraint_parameters(),
            margin=planner.margin,
            reduced=np.zeros(model.nx),
            slopes=np.zeros((model.n_constraints, model.nx)),
        ),
        n_constraints=model.n_constraints,
        horizon=planner.horizon_steps,
        time_step=planner.time_step,
        cost=lagrangian_cost(model),
        bounds=lagrangian_bounds(model),
        constraint_names=model.constraint_names,
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
