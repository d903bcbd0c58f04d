"""The door problem: quasi-static dynamics with the analytic collision constraints (the paper's)."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.collision.rows.listed import Kinds
from doorman.exceptions import ScenarioError
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.balance import balance_numbers
from doorman.model import Model
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Problem
from doorman.ocp.problem.terms import Constraint
from doorman.planning.composition import NO_EXTRAS, Extras, Made, task_problem
from doorman.planning.limits import least_cosine, tied_bounds
from doorman.planning.pace import time_constant_held

_PAPER_STATE_WEIGHTS = (5.0, 5.0, 3.0, 9.0, 8.0)
_PAPER_INPUT_WEIGHTS = (0.1, 5.0, 5.0, 13.5)
_SIDE_WEIGHT = 5.0
"""Weight of a force to the side, as a share of the vehicle's weight: the cost of the tilt that would make it."""


def door_problem(model: Model, numbers: Numbers | None = None, extras: Extras = NO_EXTRAS) -> Problem:
    """Optimal control problem of a scenario: the paper's cost, dynamics and hard constraints."""
    cost, bounds = door_cost(model), tied_bounds(model, 5, body_rates=True)
    return task_problem("quasi-static", quasi_static, model, numbers or door_numbers(model), cost, bounds, extras)


def door_numbers(model: Model) -> Numbers:
    """Numbers of the scenario's task, by name: geometry, margin and tilt, and the balance of an arm with mass."""
    limits = {"limits.margin": model.scenario.planner.margin, "limits.least_cosine": least_cosine(model)}
    rotors = model.actuation.rotors
    side = {} if rotors is None else {"actuation.side": np.zeros(2), **rotors.numbers}
    return model.reduced.numbers.and_also({**limits, **side, **balance_numbers(model.vehicle)})


def quasi_static(pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers, kinds: Kinds) -> Made:
    """The task with quasi-static dynamics."""
    from doorman.dynamics.quasi_static import QuasiStaticTask  # CasADi

    task = QuasiStaticTask(pattern, point_names, numbers)
    return task, door_rows(task, kinds), []


def door_rows(task: Any, kinds: Kinds) -> list[Constraint]:
    """Collision constraints with margin, the tilt (angle between the body's and the world's z axis), and the rotors."""
    from doorman.collision.constraints import collision_constraints  # CasADi
    from doorman.planning.vehicle_rows import rotor_thrusts, static_moment  # CasADi

    return [
        *collision_constraints(task, task.limits.margin, kinds),
        Constraint("tilt", task.limits.least_cosine - task.tilt_rotation[2, 2]),
        *static_moment(task),
        *rotor_thrusts(task),
    ]


def door_cost(model: Model) -> QuadraticCost:
    """The scenario's cost; where it gives no weights the paper's, extended to the arm's joints, at the pace of the scenario.

    A vehicle of another size has the paper's weights of forces, rates and times in its own units: it does the same, larger.
    """
    n, side = model.n_arm, np.zeros(2 if model.actuation.fully else 0)
    weight = model.vehicle.weight
    time, force = model.scale.time, model.scale.force
    by_state = np.array([*_PAPER_STATE_WEIGHTS, *([0.05] + [0.1] * n)[:n]])
    by_state[4] = time_constant_held(model) ** 2 * by_state[3]
    by_input = np.array([*_PAPER_INPUT_WEIGHTS, *[10.0] * n]) * time**2
    by_input[0] /= time**2 * force**2
    by_state = chosen_weights(model, "state", by_state)
    return QuadraticCost(
        state_weights=by_state,
        terminal_weights=time * by_state,
        input_weights=np.concatenate([chosen_weights(model, "input", by_input), side + _SIDE_WEIGHT / weight**2]),
        state_goal=model.goal_state,
        input_goal=np.concatenate([_holding_input(model), side]),
    )


def chosen_weights(model: Model, name: str, default: Array) -> Array:
    """The diagonal `planner.weights.<name>`."""
    given = getattr(model.scenario.planner.weights, name)
    if given is not None and len(given) != len(default):
        raise ScenarioError(
            "wrong number of weights", file=model.scenario.source, field=f"planner.weights.{name}", given=len(given),
            allowed=f"{len(default)} for an arm of {model.n_arm} joints",
        )  # fmt: skip
    return np.array(default if given is None else given)


def _holding_input(model: Model) -> Array:
    r"""Inputs at the goal: hover, with the thrust :math:`|m_A g e_3 - G n_D / J_n|` where the tip holds the leaf's weight."""
    angle, door = model.goal_angle, model.door
    holds = np.array(model.hover_input)
    push = -door.weight_torque(angle) / model.coupling.lever_length
    if push != 0.0:
        holds[0] = np.linalg.norm(push * door.normal(angle) + [0.0, 0.0, holds[0]])
    return holds
