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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.dynamics.quasi_static import quasi_static_step, quasi_static_step_jacobian
from doorman.kinematics.arm import ArmParameters, arm_kinematics, point_derivative
from doorman.model import GRAVITY, Model
from doorman.numba_types.lanes import sincos
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem
from doorman.planning.door_problem import (
    DoorModel,
    constrain_door,
    constrain_door_horizon,
    door_cost,
    linearize_door_constraints,
    linearize_door_horizon,
)
from doorman.planning.hinge import Hinge
from doorman.planning.limits import reduced_bounds

Array = NDArray[np.float64]

N_STATE_ROWS = 8
"""Rows of h beyond the door problem's."""
N_INPUT_ROWS = 2
"""Rows of g."""

_ROUNDING = 0.01
"""Of max(0, α − α_g) [rad]."""
CREEP = 0.015
"""Speed at which a door may always move: it stops within a fraction of a degree [rad/s]."""


_ROOM = 1.3
"""Where a start is outside, constraints are widened by so much more than it needs."""
_NOTED = 1.05
"""Constraints that are widened by a larger factor are worth a word."""


class PushHinge(NamedTuple):
    """What a plan takes of the hinge, and where the plan starts; see `hinge_of`."""

    deceleration: float
    """a, half of what α̇² may be per angle left [rad/s²]."""
    slack: float
    """e, so that the start is inside [rad²/s²]."""
    speed: float
    """Largest |α̇| [rad/s]."""
    least_force: float
    """λ_min [N]."""
    acceleration: float
    """a_max [rad/s²]."""


class PushModel(NamedTuple):
    """Parameters and memory of the push problem's kernels."""

    door: DoorModel
    """Its dynamics move I_e."""
    hinge: PushHinge
    goal: float
    """α_g [rad]."""
    leaf_share: float
    """I_D/I_e."""
    vehicle_share: float
    """m_A D_V/I_e [1/m]."""
    mass: float
    """m_A [kg]."""
    weight: float
    """m_A g [N]."""
    cone: float
    """μ/√2."""
    yaw_torque: float
    """M_max [N m]."""


@functions.implement(functions.step, PushModel)
@kernel
def _step(model: PushModel, x: Array, u: Array, out: Array) -> None:
    quasi_static_step(model.door.dynamics, x, u, out)


@functions.implement(functions.linearize_step, PushModel)
@kernel
def _linearize_step(model: PushModel, x: Array, u: Array, jacobian: Array) -> None:
    quasi_static_step_jacobian(model.door.dynamics, x, u, jacobian)


@kernel
def _stopping(model: PushModel, angle: float, rate: float) -> tuple[float, float]:
    """Value of the row that keeps the door stoppable, and its slope by the angle; that by the rate is the rate."""
    left = angle - model.goal
    root = math.sqrt(left * left + _ROUNDING * _ROUNDING)
    hinge = model.hinge
    value = 0.5 * rate * rate - hinge.deceleration * 0.5 * (left + root) - hinge.slack
    return value, -hinge.deceleration * 0.5 * (1.0 + left / root)


@kernel
def _hinge_torque(model: PushModel, angle: float, rate: float) -> tuple[float, float, float]:
    """Torque τ of the hinge in the sense of damping, and its slopes by angle and rate."""
    p = model.door.dynamics
    torque, slope = p.damping * rate + p.stiffness * (angle - p.rest_angle) + p.disturbance, p.damping
    if p.friction > 0.0:
        slip = math.tanh(rate / p.friction_rate)
        torque += p.friction * slip
        slope += p.friction * (1.0 - slip * slip) / p.friction_rate
    return torque, p.stiffness, slope


@kernel
def _directions(x: Array) -> tuple[float, float, float, float, float, float, float]:
    """Shares of the thrust along normal, leaf and vertical, and sines and cosines of roll and pitch."""
    sr, cr = sincos(x[0])
    sp, cp = sincos(x[1])
    sd, cd = sincos(x[3] - x[2])
    return cr * sp * sd + sr * cd, cr * sp * cd - sr * sd, cr * cp, sr, cr, sp, cp


@kernel
def _level(x: Array, vector: tuple[float, float, float]) -> tuple[float, float]:
    """Horizontal parts along normal and leaf of a vector in the body."""
    sr, cr = sincos(x[0])
    sp, cp = sincos(x[1])
    sd, cd = sincos(x[3] - x[2])
    forward = cp * vector[0] + sp * (sr * vector[1] + cr * vector[2])
    left = cr * vector[1] - sr * vector[2]
    return forward * sd - left * cd, forward * cd + left * sd


@kernel
def _level_by_roll(x: Array, dx: float, dy: float, dz: float) -> tuple[float, float]:
    """Slopes of `_level` by roll."""
    sr, cr = sincos(x[0])
    sp, _ = sincos(x[1])
    sd, cd = sincos(x[3] - x[2])
    forward, left = sp * (cr * dy - sr * dz), -sr * dy - cr * dz
    return forward * sd - left * cd, forward * cd + left * sd


@kernel
def _tip(arm: ArmParameters, x: Array) -> tuple[float, float, float]:
    """Tip in the body; `arm.joints` are at x afterwards."""
    arm_kinematics(arm, x[5:])
    tip = arm.points.shape[0] - 1
    return arm.points[tip, 0], arm.points[tip, 1], arm.points[tip, 2]


@kernel
def _constrain_push(model: PushModel, x: Array, h: Array, last: int) -> None:
    """Rows of the push into `h` from `last` on."""
    hinge, p = model.hinge, model.door.dynamics
    h[last], _ = _stopping(model, x[3], x[4])
    h[last + 1] = -x[4] - hinge.speed
    across, beside, up, _, _, _, _ = _directions(x)
    torque, _, _ = _hinge_torque(model, x[3], x[4])
    push = model.weight * across / up
    along = model.weight * beside / up + model.mass * p.distance_from_hinge * x[4] * x[4]
    normal = model.leaf_share * push - model.vehicle_share * torque
    h[last + 2] = (hinge.least_force - normal) / model.weight
    h[last + 3] = (along - model.cone * normal) / model.weight
    h[last + 4] = (-along - model.cone * normal) / model.weight
    h[last + 5] = (p.distance_from_hinge * push + torque) / p.door_inertia - hinge.acceleration
    ahead, aside = _level(x, _tip(model.door.collision.arm, x))
    turning = aside * normal - ahead * along
    h[last + 6] = (turning - model.yaw_torque) / model.weight
    h[last + 7] = (-turning - model.yaw_torque) / model.weight


@kernel
def _linearize_push(model: PushModel, x: Array, h: Array, jacobian: Array, last: int) -> None:
    """The same with slopes; entries that are always zero are not written."""
    _constrain_push(model, x, h, last)
    p = model.door.dynamics
    _, jacobian[last, 3] = _stopping(model, x[3], x[4])
    jacobian[last, 4] = x[4]
    jacobian[last + 1, 4] = -1.0
    across, beside, up, sr, cr, sp, cp = _directions(x)
    sd, cd = sincos(x[3] - x[2])
    _, by_angle, by_rate = _hinge_torque(model, x[3], x[4])
    scale = 1.0 / (up * up)  # forces as shares of the weight
    by_roll = scale * ((cr * cd - sr * sp * sd) * up + across * sr * cp)
    by_pitch = scale * (cr * cp * sd * up + across * cr * sp)
    turn = beside / up
    pushes = (by_roll, by_pitch, -turn, turn)
    along_by_roll = scale * (-(sr * sp * cd + cr * sd) * up + beside * sr * cp)
    along_by_pitch = scale * (cr * cp * cd * up + beside * cr * sp)
    along_turn = across / up
    alongs = (along_by_roll, along_by_pitch, along_turn, -along_turn)
    for i in range(4):
        jacobian[last + 2, i] = -model.leaf_share * pushes[i]
        jacobian[last + 3, i] = alongs[i]
        jacobian[last + 5, i] = p.distance_from_hinge / p.door_inertia * model.weight * pushes[i]
    jacobian[last + 2, 3] += model.vehicle_share * by_angle / model.weight
    jacobian[last + 2, 4] = model.vehicle_share * by_rate / model.weight
    jacobian[last + 3, 4] = 2.0 * model.mass * p.distance_from_hinge * x[4] / model.weight
    jacobian[last + 5, 3] += by_angle / p.door_inertia
    jacobian[last + 5, 4] = by_rate / p.door_inertia
    normal = model.hinge.least_force / model.weight - h[last + 2]
    along = 0.5 * (h[last + 3] - h[last + 4])
    dx, dy, dz = _tip(model.door.collision.arm, x)
    ahead, aside = _level(x, (dx, dy, dz))
    rolled = _level_by_roll(x, dx, dy, dz)
    raised = sr * dy + cr * dz
    pitched = (-sp * dx + cp * raised) * sd, (-sp * dx + cp * raised) * cd
    tips = (rolled, pitched, (-aside, ahead), (aside, -ahead), (0.0, 0.0))
    for i in range(5):
        tip_ahead, tip_aside = tips[i]
        pressing, sideways = -jacobian[last + 2, i], jacobian[last + 3, i]
        turning = aside * pressing - ahead * sideways + tip_aside * normal - tip_ahead * along
        jacobian[last + 6, i] = turning
        jacobian[last + 7, i] = -turning
        jacobian[last + 3, i] = sideways - model.cone * pressing
        jacobian[last + 4, i] = -sideways - model.cone * pressing
    arm = model.door.collision.arm
    for j in range(arm.joints.shape[0]):
        tip_ahead, tip_aside = _level(x, point_derivative(arm, arm.points.shape[0] - 1, j))
        turning = tip_aside * normal - tip_ahead * along
        jacobian[last + 6, 5 + j] = turning
        jacobian[last + 7, 5 + j] = -turning


@functions.implement(functions.constrain, PushModel)
@kernel
def _constrain(model: PushModel, x: Array, h: Array) -> None:
    last = h.shape[0] - N_STATE_ROWS
    constrain_door(model.door, x, h[:last])
    _constrain_push(model, x, h, last)


@functions.implement(functions.linearize_constraints, PushModel)
@kernel
def _linearize_constraints(model: PushModel, x: Array, h: Array, jacobian: Array) -> None:
    last = h.shape[0] - N_STATE_ROWS
    linearize_door_constraints(model.door, x, h[:last], jacobian[:last])
    jacobian[last:, :] = 0.0
    _linearize_push(model, x, h, jacobian, last)


@functions.implement(functions.linearize_horizon, PushModel)
@kernel
def _linearize_horizon(
    model: PushModel, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    last = rows.shape[1] - N_STATE_ROWS
    linearize_door_horizon(model.door, states, inputs, jacobians, rows[:, :last], row_jacobians[:, :last])
    for k in range(inputs.shape[0]):
        _linearize_push(model, states[k + 1], rows[k], row_jacobians[k], last)


@functions.implement(functions.constrain_horizon, PushModel)
@kernel
def _constrain_horizon(model: PushModel, states: Array, rows: Array) -> None:
    last = rows.shape[1] - N_STATE_ROWS
    constrain_door_horizon(model.door, states, rows[:, :last])
    for k in range(rows.shape[0]):
        _constrain_push(model, states[k + 1], rows[k], last)


@functions.implement(functions.constrain_input, PushModel)
@kernel
def _constrain_input(model: PushModel, x: Array, u: Array, g: Array) -> None:
    _, _, up, _, _, _, _ = _directions(x)
    upwards, most = u[0] / model.weight * up - 1.0, model.cone * model.hinge.least_force / model.weight
    g[0] = upwards - most
    g[1] = -upwards - most


@functions.implement(functions.linearize_input_constraints, PushModel)
@kernel
def _linearize_input_constraints(model: PushModel, x: Array, u: Array, g: Array, jacobian: Array) -> None:
    _constrain_input(model, x, u, g)
    jacobian[:, :] = 0.0
    _, _, up, sr, cr, sp, cp = _directions(x)
    for row, sign in ((0, 1.0), (1, -1.0)):
        jacobian[row, 0] = -sign * u[0] / model.weight * sr * cp
        jacobian[row, 1] = -sign * u[0] / model.weight * cr * sp
        jacobian[row, x.shape[0]] = sign * up / model.weight


def push_problem(model: Model) -> Problem:
    """Optimal control problem of a scenario whose tip can only push.

    Args:
        model: Model of the scenario.

    Returns:
        The problem; `hinge_of` fits it to what is known of the hinge, and to a start.

    Raises:
        ScenarioError: if a vector of weights does not fit the arm.
    """
    planner, push = model.scenario.planner, model.scenario.push
    mass = model.vehicle.mass
    parameters = PushModel(
        door=DoorModel.of(model, 0.0),
        hinge=PushHinge(0.0, 0.0, push.max_rate, push.least_force, push.max_acceleration),
        goal=float(model.goal_state[3]),
        leaf_share=0.0,
        vehicle_share=0.0,
        mass=mass,
        weight=mass * GRAVITY,
        cone=push.friction_coefficient / math.sqrt(2.0),
        yaw_torque=push.max_yaw_torque,
    )
    return Problem(
        model=with_hinge(model, parameters, Hinge.of(model.door), model.start_state),
        n_constraints=model.n_constraints + 1 + N_STATE_ROWS,
        n_input_constraints=N_INPUT_ROWS,
        integrators=model.n_arm,
        bounds=reduced_bounds(model),
        constraint_names=(*model.constraint_names, "tilt", "door can be stopped", "door's speed", "tip presses",
                          "tip does not slip to the latch", "tip does not slip to the hinge", "door's acceleration",
                          "tip turns the vehicle left", "tip turns the vehicle right",
                          "tip does not slip upwards", "tip does not slip downwards"),
        horizon=planner.horizon_steps,
        time_step=planner.time_step,
        cost=door_cost(model),
    )  # fmt: skip


def with_hinge(
    model: Model, parameters: PushModel, known: Hinge, start: Array, margin: float | None = None
) -> PushModel:
    r"""Fit the problem to what is known of the hinge, and to a start that may lie outside the constraints.

    With the resistance :math:`\hat\tau` against opening at the start, :math:`a = \eta\hat\tau/I_e` and
    :math:`\lambda_{min}` belongs to a push of `push.least_share` :math:`\hat\tau/D_V`, at least to `push.least_force`.
    A door that moves and that even the least push makes faster, as one that wind opens, may get as fast as that makes it
    within the horizon: the plan cannot help it, and keeps everything else. One that stands is not set in motion.

    Args:
        model: Model of the scenario.
        parameters: The problem's.
        known: The hinge as the plan takes it.
        start: Reduced state, shape (5 + n,).
        margin: Distance from door and frame; that of `parameters` if not given [m].

    Returns:
        Parameters of a problem that contains the start.
    """
    push, door = model.scenario.push, parameters.door
    lever = door.dynamics.distance_from_hinge
    moving = known.inertia + parameters.mass * lever**2
    leaf_share, vehicle_share = known.inertia / moving, parameters.mass * lever / moving
    dynamics = known._replace(inertia=moving).into(door.dynamics)
    angle, rate = float(start[3]), float(start[4])
    torque = dynamics.damping * rate + dynamics.stiffness * (angle - dynamics.rest_angle) + known.disturbance
    resistance = max(0.0, known.friction - torque)
    deceleration = push.stopping_share * resistance / dynamics.door_inertia
    least_force = max(push.least_force, (leaf_share * push.least_share + vehicle_share * lever) * resistance / lever)
    moves = rate < -CREEP
    ahead = model.scenario.planner.horizon_steps * model.scenario.planner.time_step
    faster = _ROOM * max(0.0, lever * least_force + torque - known.friction) / known.inertia if moves else 0.0
    fastest = max(0.0, -rate) + faster * ahead
    left = angle - parameters.goal - (fastest * ahead if faster > 0.0 else 0.0)
    allowed = deceleration * 0.5 * (left + math.hypot(left, _ROUNDING)) + 0.5 * CREEP**2
    hinge = PushHinge(
        deceleration=deceleration,
        slack=0.5 * CREEP**2 + _ROOM * max(0.0, 0.5 * fastest * fastest - allowed),
        speed=max(push.max_rate, fastest),
        least_force=least_force,
        acceleration=max(push.max_acceleration, faster),
    )  # fmt: skip
    door = door._replace(dynamics=dynamics, margin=door.margin if margin is None else margin)
    return parameters._replace(hinge=hinge, door=door, leaf_share=leaf_share, vehicle_share=vehicle_share)


def is_relaxed(model: Model, parameters: PushModel) -> bool:
    """Whether the constraints had to be widened for the start, by more than sensors' noise."""
    hinge = parameters.hinge
    return hinge.slack > _NOTED * CREEP**2 or hinge.speed > _NOTED * model.scenario.push.max_rate
