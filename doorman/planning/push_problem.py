r"""The door problem for a tip that can only push: vehicle and leaf move as one, the tip's force stays in its cone.

With :math:`I_e = I_D + m_A D_V^2`, the inertia that the push really moves, the rotors' push :math:`F_n = f_t\,n_D^T R e_3` and
the hinge's torque τ in the sense of damping,

.. math::
    \ddot\alpha = -\frac{D_V F_n + \tau}{I_e},\qquad
    \lambda_n = -\frac{I_D\ddot\alpha + \tau}{D_V} = \frac{I_D}{I_e}F_n - \frac{m_A D_V}{I_e}\tau

are the swing and the tip's normal force on the leaf; along the leaf and upwards it takes
:math:`\lambda_t = f_t\,t_D^T R e_3 + m_A D_V\dot\alpha^2` and :math:`\lambda_z = f_t\,e_3^T R e_3 - m_A g`.

The tip carries next to no weight, so that :math:`f_t e_3^T R e_3 = m_A g` up to λ_z, and an attitude by itself fixes F_n, λ_n and
λ_t. Hence these are constraints of states, which the body rates before them can always meet:

1. the door can be stopped before the goal, :math:`\tfrac12\dot\alpha^2 \le a\,\sigma(\alpha - \alpha_g) + e`, with the
   deceleration a that its own resistance surely gives; σ is max(0, ·), rounded;
2. it is no faster than the limit;
3. the tip presses, :math:`\lambda_n \ge \lambda_{min}`;
4. it does not slip sideways, :math:`|\lambda_t| \le \mu\lambda_n/\sqrt 2`;
5. the door is not thrown, :math:`-\ddot\alpha \le a_{max}`;
6. the rotors can hold the vehicle's heading against the tip's force, :math:`|r_t\lambda_n - r_n\lambda_t| \le M_{max}`, with the
   tip at :math:`r_n n_D + r_t t_D` from O_B: drag makes little torque, and a vehicle that pushes beside its centre of mass spins;

and what is left for the input is that it does not slip up or down, :math:`|\lambda_z| \le \mu\lambda_{min}/\sqrt 2`. Both
ends of an absolute value are rows of their own: a cone's tip would be too sharp for linearised steps. Forces are rows as
shares of the weight, so that their slopes by roll and pitch are near one, as those of the other rows. docs/push.md has the
proof that (1) can always be kept.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.collision.surroundings import Surroundings
from doorman.kinematics.arm_pattern import ArmPattern
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.ocp.problem.terms import Constraint
from doorman.planning.composition import NO_EXTRAS, Extras, task_text
from doorman.planning.door_problem import door_numbers, door_rows, scenario_problem
from doorman.planning.hinge import Hinge

Array = NDArray[np.float64]

_ROUNDING = 0.01
"""Of max(0, α − α_g) [rad]."""
CREEP = 0.015
"""Speed at which a door may always move: it stops within a fraction of a degree [rad/s]."""
_ROOM = 1.3
"""Where a start is outside, constraints are widened by so much more than it needs."""
_NOTED = 1.05
"""Constraints that are widened by a larger factor are worth a word."""


def push_problem(model: Model, numbers: Numbers | None = None, extras: Extras = NO_EXTRAS) -> Problem:
    """Optimal control problem of a scenario whose tip can only push.

    Args:
        model: Model of the scenario.
        numbers: Of the task; those at the scenario's start if not given.
        extras: The user's constraints and costs.

    Returns:
        The problem; `with_hinge` fits its numbers to what is known of the hinge, and to a start.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
        SolverError: if an expression of the user is none.
    """
    numbers = numbers or with_hinge(model, push_numbers(model), Hinge.of(model.door), model.start_state)
    rows = partial(_rows, surroundings=model.surroundings)
    text = task_text(f"push {model.surroundings}", _push_task, model, numbers, rows, extras)
    return scenario_problem(model, text, numbers)


def push_numbers(model: Model) -> Numbers:
    """Numbers of the scenario's task; those that `with_hinge` fits are what `[push]` says, or zero."""
    push = model.scenario.push
    return door_numbers(model).and_also(
        {
            "push.goal": model.goal_state[3],
            "push.cone": push.friction_coefficient / math.sqrt(2.0),
            "push.yaw_torque": push.max_yaw_torque,
            "push.deceleration": 0.0,
            "push.slack": 0.0,
            "push.speed": push.max_rate,
            "push.least_force": push.least_force,
            "push.acceleration": push.max_acceleration,
        }
    )


def _push_task(pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> Any:
    """The task in symbols."""
    from doorman.dynamics.push import PushTask  # CasADi

    return PushTask(pattern, point_names, numbers)


def _rows(task: Any, surroundings: Surroundings) -> list[Constraint]:
    """The door problem's constraints and the push's, as in the module's docstring."""
    push, weight, left = task.push, task.weight, task.door_angle - task.push.goal
    to_go = 0.5 * (left + (left**2 + _ROUNDING**2) ** 0.5)
    friction, normal, along = push.cone * task.normal_force, task.normal_force, task.force_along_leaf
    lift = push.cone * push.least_force / weight
    return [
        *door_rows(task, surroundings),
        Constraint("door can be stopped", 0.5 * task.door_rate**2 - push.deceleration * to_go - push.slack),
        Constraint("door's speed", task.opening_rate - push.speed),
        Constraint("tip presses", (push.least_force - normal) / weight),
        Constraint("tip does not slip to the latch", (along - friction) / weight),
        Constraint("tip does not slip to the hinge", (-along - friction) / weight),
        Constraint("door's acceleration", task.door_acceleration - push.acceleration),
        Constraint("tip turns the vehicle left", (task.yaw_moment - push.yaw_torque) / weight),
        Constraint("tip turns the vehicle right", (-task.yaw_moment - push.yaw_torque) / weight),
        Constraint("tip does not slip upwards", task.lift - lift),
        Constraint("tip does not slip downwards", -task.lift - lift),
    ]


def with_hinge(model: Model, numbers: Numbers, known: Hinge, start: Array, margin: float | None = None) -> Numbers:
    r"""Fit the problem to what is known of the hinge, and to a start that may lie outside the constraints.

    With the resistance :math:`\hat\tau` against opening at the start, :math:`a = \eta\hat\tau/I_e` and
    :math:`\lambda_{min}` belongs to a push of `push.least_share` :math:`\hat\tau/D_V`, at least to `push.least_force`.
    A door that moves and that even the least push makes faster, as one that wind opens, may get as fast as that makes it
    within the horizon: the plan cannot help it, and keeps everything else. One that stands is not set in motion.

    Args:
        model: Model of the scenario.
        numbers: The problem's.
        known: The hinge as the plan takes it.
        start: Reduced state, shape (5 + n,).
        margin: Distance from door and frame; that of `numbers` if not given [m].

    Returns:
        Numbers of a problem that contains the start.
    """
    push, mass, lever = model.scenario.push, model.vehicle.mass, model.coupling.distance_from_hinge
    moving = known.inertia + mass * lever**2
    leaf_share, vehicle_share = known.inertia / moving, mass * lever / moving
    angle, rate = float(start[3]), float(start[4])
    torque = known.damping * rate + known.torque_at_rest(angle, model.door.rest_angle)
    resistance = max(0.0, known.friction - torque)
    deceleration = push.stopping_share * resistance / moving
    least_force = max(push.least_force, (leaf_share * push.least_share + vehicle_share * lever) * resistance / lever)
    moves = rate < -CREEP
    ahead = model.scenario.planner.horizon_steps * model.scenario.planner.time_step
    faster = _ROOM * max(0.0, lever * least_force + torque - known.friction) / known.inertia if moves else 0.0
    fastest = max(0.0, -rate) + faster * ahead
    left = angle - float(model.goal_state[3]) - (fastest * ahead if faster > 0.0 else 0.0)
    allowed = deceleration * 0.5 * (left + math.hypot(left, _ROUNDING)) + 0.5 * CREEP**2
    return numbers.replaced(
        {
            **known.numbers(),
            "door.moving_inertia": moving,
            "push.deceleration": deceleration,
            "push.slack": 0.5 * CREEP**2 + _ROOM * max(0.0, 0.5 * fastest * fastest - allowed),
            "push.speed": max(push.max_rate, fastest),
            "push.least_force": least_force,
            "push.acceleration": max(push.max_acceleration, faster),
            **({} if margin is None else {"limits.margin": margin}),
        }
    )


def is_relaxed(model: Model, numbers: Numbers) -> bool:
    """Whether the constraints had to be widened for the start, by more than sensors' noise."""
    slack, speed = numbers.one("push.slack"), numbers.one("push.speed")
    return slack > _NOTED * CREEP**2 or speed > _NOTED * model.scenario.push.max_rate
