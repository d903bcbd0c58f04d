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
from doorman.dynamics.quasi_static import QuasiStaticParameters, quasi_static_step, quasi_static_step_jacobian
from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.ocp import functions
from doorman.ocp.costs import QuadraticCost
from doorman.ocp.problem import Problem

Array = NDArray[np.float64]

_PAPER_STATE_WEIGHTS = (5.0, 5.0, 3.0, 9.0, 8.0)
_PAPER_INPUT_WEIGHTS = (0.1, 5.0, 5.0, 13.5)


class DoorModel(NamedTuple):
    """Parameters of the door problem's kernels."""

    dynamics: QuasiStaticParameters
    collision: ConstraintParameters
    margin: float


@functions.implement(functions.step, DoorModel)
@kernel
def _step(model: DoorModel, x: Array, u: Array, out: Array) -> None:
    quasi_static_step(model.dynamics, x, u, out)


@functions.implement(functions.linearize_step, DoorModel)
@kernel
def _linearize_step(model: DoorModel, x: Array, u: Array, out: Array) -> None:
    quasi_static_step_jacobian(model.dynamics, x, u, out)


@functions.implement(functions.constrain, DoorModel)
@kernel
def _constrain(model: DoorModel, x: Array, h: Array) -> None:
    collision_constraints(model.collision, x, h)
    for i in range(h.shape[0]):
        h[i] += model.margin


@functions.implement(functions.linearize_constraints, DoorModel)
@kernel
def _linearize_constraints(model: DoorModel, x: Array, h: Array, jacobian: Array) -> None:
    collision_constraints_jacobian(model.collision, x, h, jacobian)
    for i in range(h.shape[0]):
        h[i] += model.margin


def door_problem(model: Model, disturbance: float = 0.0) -> Problem:
    """Optimal control problem of a scenario: the paper's cost, dynamics and hard constraints.

    Args:
        model: Model of the scenario.
        disturbance: τ_d, torque in the sense of damping, beyond damping, friction and spring [N m].

    Returns:
        The problem, whose constraints are h(x) + planner.margin ≤ 0.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
    """
    planner = model.scenario.planner
    return Problem(
        model=DoorModel(model.dynamics_parameters(disturbance), model.constraint_parameters(), planner.margin),
        n_constraints=model.n_constraints,
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
