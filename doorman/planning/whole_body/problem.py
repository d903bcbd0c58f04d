"""The whole-body problem of a scenario: numbers of its task, bounds, cost, and what a plan begins with.

All that changes in flight is a number: wind, hinge, where the tip sticks, references and weights. Nothing is compiled anew.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.collision.surroundings import Surroundings, rows_beside
from doorman.exceptions import BackendError
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.scale import Scale
from doorman.kinematics.vehicles.actuation import LEVEL
from doorman.kinematics.vehicles.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.balance import balance_numbers
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.model import GRAVITY, Model
from doorman.ocp.kernels.printed_problem import printed_problem
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem
from doorman.ocp.problem.terms import Constraint, Residual
from doorman.planning.composition import NO_EXTRAS, Extras, task_text
from doorman.planning.mechanism_numbers import mechanism_numbers

Array = NDArray[np.float64]

ARM_RATE = 1.5
"""Largest joint rate of a plan, of the shipped vehicle [rad/s]."""
LEAST_THRUST = 0.17
"""As a share of the weight."""
_SHIPPED_YAW_TORQUE = 0.25
"""[N m]."""
STATE_WEIGHT = 1e-6
"""Of every state: residuals do the rest."""
INPUT_WEIGHTS = (0.3, 0.2, 0.2, 2.0)
"""Of thrust, commanded roll and pitch, and yaw torque, of the shipped vehicle. Cheap thrust is used to push, faster than rotors
follow."""
SIDE_WEIGHT, LEVEL_WEIGHT = 0.3, 300.0
"""Of a change of the force to the side, of the shipped vehicle, and of roll and pitch, of a fully actuated vehicle."""
SIDE_COST = 1e-3
"""Of the force to the side itself."""
ARM_WEIGHT = 50.0
"""Of every joint rate, of the shipped vehicle. Cheaper arms rattle the tip: with a tenth of this, pushes above 4.5 N grow to
oscillations."""


_ROOM = (0.03, 1e3, 1.0, 1.0)
"""By which rows are widened for the shipped vehicle: planes, force, speed and stopping. Noise moves a start across tight rows,
and plans of one iteration do not converge there; residuals keep the distance instead."""


def whole_body_numbers(model: Model) -> Numbers:
    """Numbers of a scenario's task, by the names that `WholeBodyTask` knows them by: the tip touches and opens.

    Args:
        model: Model of the scenario.
    """
    vehicle, door, scenario = model.vehicle, model.door, model.scenario
    start, goal = model.start_state, model.goal_state
    scale = scale_of(model)
    slope = (start - goal) / (start[3] - goal[3])
    balance = balance_numbers(vehicle)
    before = len(vehicle.point_names) + len(balance.get("balance.reaches", ()))
    return Numbers({
        **balance, **_side_numbers(model),
        "arm.numbers": ArmPattern.of(vehicle.arm)[1],
        "vehicle.mass": vehicle.mass, "vehicle.radius": vehicle.radius,
        "vehicle.yaw_inertia": yaw_inertia(model),
        "vehicle.attitude_gain": model.attitude_loop.gain, "vehicle.rate_gain": model.attitude_loop.rate_gain,
        "vehicle.tilt_stiffness": tilt_stiffness(model), "vehicle.tilt_offset": np.zeros(2),
        "vehicle.wind": np.zeros(3),
        **mechanism_numbers(model),
        **_beside(model),
        "mechanism.sense": math.copysign(1.0, goal[3] - start[3]),
        "mechanism.inertia": door.inertia, "mechanism.damping": door.damping, "mechanism.friction": door.friction,
        "mechanism.friction_rate": 0.02 * scale.rate, "mechanism.stiffness": door.stiffness, "mechanism.rest": door.rest_angle,
        "mechanism.torque": 0.0, "mechanism.sticks": 0.0,
        "contact.stiffness": 1500.0 * scale.stiffness, "contact.damping": 50.0 * scale.damping,
        "contact.smoothing": 1e-3 * scale.length,
        "contact.friction": scenario.push.friction_coefficient,
        "contact.stick": np.zeros(2), "contact.give": 0.004 * scale.length,
        "contact.slip_damping": 10.0 * scale.damping,
        "limits.margin": scenario.planner.margin, "limits.width": door.width, "limits.force": 15.0 * scale.force,
        "limits.speed": scenario.push.max_rate, "limits.deceleration": 0.0, "limits.rounding": 0.01,
        "limits.creep": 0.5 * (0.015 * scale.rate) ** 2,
        "limits.widened": np.concatenate([np.zeros(before), *_room_of_rows(model)]),
        "reference.joint": goal[3], "reference.position": np.zeros(3), "reference.heading": [goal[2], slope[2]],
        "reference.arm": goal[5:], "reference.arm_slope": slope[5:],
        "reference.depth": 0.02 * scale.length, "reference.approach_speed": 0.08 * scale.speed,
        "reference.approach_length": 0.08 * scale.length,
        "reference.opening_speed": scenario.push.max_rate, "reference.opening_length": 0.2, "reference.force": 0.0,
        "reference.least_force": 0.5 * scale.force, "reference.largest_force": 12.0 * scale.force,
        "reference.turned": np.zeros(2), "reference.room": 0.03 * scale.length, "weight.near": 300.0 / scale.length**2,
        "plan.time_step": scenario.planner.time_step,
        "weight.place": 40.0 / scale.length**2, "weight.position": 0.0, "weight.heading": 16.0,
        "weight.arm": 30.0,
        "weight.approach": 1000.0 / scale.speed**2, "weight.opening": 100.0 / scale.rate**2,
        "weight.force": 0.0, "weight.least_force": 0.0,
        "weight.largest_force": 1.0 / scale.force**2, "weight.tilting": 300.0,
        "weight.velocity_in_world": 0.3 / scale.speed**2, "weight.turning": 0.5 / scale.rate**2,
    })  # fmt: skip


def _room_of_rows(model: Model) -> tuple[Array, Array]:
    """By how much rows are widened: the planes, and force, speed and stopping."""
    scale, planes = scale_of(model), 1 + len(rows_beside(model.surroundings))
    units = np.array([scale.force, scale.rate, scale.rate**2])
    return np.full(planes, _ROOM[0] * scale.length), np.array(_ROOM[1:]) * units


def _beside(model: Model) -> dict[str, Any]:
    """Numbers of what stands beside the door, where it is not the jambs all the way."""
    door = model.door
    wall = {"beside.into": door.into, "beside.frame_depth": door.frame_depth}
    of: dict[Surroundings, dict[str, Any]] = {
        "doorway": {},
        "wall": wall,
        "corners": {**wall, "beside.frame_back": door.frame_back, "beside.width": door.width},
    }
    if door.panel is not None:
        of["panel"] = {"beside.panel": door.from_doorway(door.panel[0]), "beside.panel_distance": door.panel[1]}
    return of[model.surroundings]


def _side_numbers(model: Model) -> dict[str, Any]:
    """Of a fully actuated vehicle: the force to the side that it makes now, and how dear a change of it and tilt are."""
    if not model.actuation.fully:
        return {}
    weights = {
        "actuation.side_weight": SIDE_WEIGHT / scale_of(model).force ** 2,
        "actuation.level_weight": LEVEL_WEIGHT,
    }
    return {"actuation.side": np.zeros(2), **weights}


def scale_of(model: Model) -> Scale:
    """Scale of a scenario's vehicle.

    Args:
        model: Model of the scenario.
    """
    return model.scale


def yaw_torque(model: Model) -> float:
    """Largest torque about the vertical that a plan counts on: a share of what the rotors make around half thrust.

    Args:
        model: Model of the scenario, whose `control.yaw_share` that is.

    Returns:
        [N m]; of rotors that cannot steer, which the check refuses, as many as the shipped ones make.
    """
    try:
        layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
    except BackendError:
        return _SHIPPED_YAW_TORQUE * scale_of(model).torque
    return float(model.scenario.control.yaw_share * layout.torque_authority[2])


def yaw_inertia(model: Model) -> float:
    """I_z of vehicle and arm in the goal's posture, about the vertical through the centre of mass [kg m²].

    Args:
        model: Model of the scenario.
    """
    center = model.vehicle.center_of_mass(model.goal_arm)
    return float(model.vehicle_inertia[2, 2] - model.vehicle.mass * center[:2] @ center[:2])


def whole_body_problem(model: Model, numbers: Numbers | None = None, extras: Extras = NO_EXTRAS) -> Problem:
    """Optimal control problem of a scenario's vehicle, arm and door, from free flight to contact.

    Args:
        model: Model of the scenario.
        numbers: Of the task; `whole_body_numbers` if not given.
        extras: The user's constraints and costs.

    Returns:
        The problem; its parameters are in the order of the numbers.

    Raises:
        SolverError: if an expression of the user is none.
    """
    numbers, planner = numbers or whole_body_numbers(model), model.scenario.planner
    make, beside = partial(_task, surroundings=model.surroundings), model.surroundings
    text = task_text(f"whole body {beside}", make, model, numbers, _constraints, extras, _residuals)
    return printed_problem(text, planner.horizon_steps, planner.time_step, _cost(model), _bounds(model), numbers.vector)


def _task(pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers, surroundings: Surroundings) -> Any:
    from doorman.planning.whole_body.model import WholeBodyTask  # CasADi

    return WholeBodyTask(pattern, point_names, numbers, surroundings)


def _constraints(task: Any) -> list[Constraint]:
    from doorman.planning.whole_body.model import constraints  # CasADi

    return constraints(task)


def _residuals(task: Any) -> list[Residual]:
    from doorman.planning.whole_body.model import residuals  # CasADi

    return residuals(task)


def whole_body_state(
    position: Array,
    attitude: Array,
    velocity: Array,
    attitude_rates: Array,
    joint: float,
    joint_rate: float,
    arm: Array,
) -> Array:
    """A state of the problem.

    Args:
        position: P, shape (3,), world frame [m].
        attitude: Φ, shape (3,) [rad].
        velocity: V, shape (3,), world frame [m/s].
        attitude_rates: Φ̇, shape (3,) [rad/s].
        joint: q [rad or m].
        joint_rate: q̇ [rad/s or m/s].
        arm: H, shape (n,) [rad].

    Returns:
        x = [P, Φ, V, Φ̇, q, q̇, H], shape (14 + n,).
    """
    return np.concatenate([position, attitude, velocity, attitude_rates, [joint, joint_rate], arm])


def contact_forces(numbers: Numbers, model: Model, states: Array) -> Array:
    """Force of the contact's spring.

    Args:
        numbers: Of the task.
        model: Model of the scenario.
        states: Shape (m, 14 + n).

    Returns:
        λ at rest, shape (m,) [N].
    """
    depths = depths_in_face(model, states[:, :3], states[:, 3:6], states[:, 12], states[:, 14:])
    pressed = 0.5 * (depths + np.sqrt(depths**2 + 4.0 * numbers.one("contact.smoothing") ** 2))
    return np.asarray(numbers.one("contact.stiffness") * pressed)


def depths_in_face(model: Model, positions: Array, attitudes: Array, door_angles: Array, arm_angles: Array) -> Array:
    r"""How deep the tip is in the face, :math:`\delta = n_D^T(P + R\,d - P_h) + o`, and the way of a slide, for many states.

    Args:
        model: Model of the scenario.
        positions: P, shape (m, 3), world frame [m].
        attitudes: Φ, shape (m, 3) [rad].
        door_angles: α, shape (m,) [rad].
        arm_angles: H, shape (m, n) [rad].

    Returns:
        δ, shape (m,) [m].
    """
    door = model.door
    ways = np.array([door.way(angle) for angle in door_angles.tolist()]) if door.slides else 0.0
    from_hinge = positions + model.coupling.tips(attitudes, arm_angles) - door.hinge_position
    return np.asarray((door.normals(door_angles) * from_hinge).sum(axis=1) + door.contact_offset + ways)


def turned_by(model: Model, attitude: Array, arm_angles: Array, force: Array) -> Array:
    """Roll and pitch beside the commanded ones that a force of the tip makes, until an integrator takes it up.

    Args:
        model: Model of the scenario.
        attitude: Φ, shape (3,) [rad].
        arm_angles: H, shape (n,) [rad].
        force: Of the tip on the leaf, shape (3,), world frame [N].

    Returns:
        Shape (2,) [rad].
    """
    lever = model.coupling.tips(np.zeros((1, 3)), arm_angles[None])[0]
    if not model.vehicle.bodies.balanced:
        lever = lever - model.vehicle.center_of_mass(arm_angles)
    (x, y, z), (ahead, left, up) = lever.tolist(), (rotation_body_to_world(attitude).T @ force).tolist()
    return np.asarray(np.array([z * left - y * up, x * up - z * ahead]) / tilt_stiffness(model))


def tilt_stiffness(model: Model) -> Array:
    """Torque with which the vehicle's attitude loop answers a tilt about the body's x and y axis [N m/rad].

    Args:
        model: Model of the scenario.

    Returns:
        Shape (2,), body frame.
    """
    return np.asarray(model.attitude_loop.stiffness * model.vehicle_inertia.diagonal()[:2])


def tip_on_face(
    model: Model, position: Array, attitude: Array, door_angle: float, arm_angles: Array
) -> tuple[float, Array]:
    """Where the tip is relative to the contact point.

    Args:
        model: Model of the scenario.
        position: P, shape (3,), world frame [m].
        attitude: Φ, shape (3,) [rad].
        door_angle: α [rad].
        arm_angles: H, shape (n,) [rad].

    Returns:
        Depth δ in the face, and the place on it, along and up, shape (2,) [m].
    """
    tip = position + model.coupling.tips(attitude[None], arm_angles[None])[0]
    off = tip - model.coupling.contact_point(door_angle)
    place = np.array([model.door.leaf_direction(door_angle) @ off, model.door.up @ off])
    return float(model.door.normal(door_angle) @ off), place


def depth_of(force: float, numbers: Numbers) -> float:
    r"""Depth at which the contact's spring makes a force.

    .. math:: \delta = \sigma - \epsilon^2/\sigma,\qquad \sigma = \lambda/k

    A plan begins where the spring makes the force that is estimated: a millimetre of noise would be newtons.

    Args:
        force: λ, positive [N].
        numbers: Of the task.

    Returns:
        δ [m].
    """
    pressed = force / numbers.one("contact.stiffness")
    return float(pressed - numbers.one("contact.smoothing") ** 2 / pressed)


def stick_place(place: Array, friction_force: Array, normal_force: float, numbers: Numbers) -> Array:
    """Where the tip sticks, if it is at a place and friction makes a force there.

    Args:
        place: Of the tip on the face, along and up, shape (2,) [m].
        friction_force: Of the tip on the face, along and up, shape (2,) [N].
        normal_force: λ [N].
        numbers: Of the task.

    Returns:
        Shape (2,) [m].
    """
    share = friction_force / max(numbers.one("contact.friction") * normal_force, 1e-6)
    share = share * min(1.0, _MOST_GRIP / max(float(np.hypot(*share)), 1e-12))
    return np.asarray(place - numbers.one("contact.give") * share / math.sqrt(1.0 - float(share @ share)))


_MOST_GRIP = 0.9
"""Share of what friction carries that a plan may begin with: nearer to 1, the tip would be far from where it sticks."""


def _bounds(model: Model) -> Bounds:
    """Of `[limits]`, `control.max_tilt` and the vehicle; a calm arm and yaw torque whatever these allow."""
    vehicle, limits, free = model.vehicle, model.scenario.limits, np.full(14, np.inf)
    rates = np.minimum(vehicle.rate_limits, ARM_RATE * scale_of(model).rate)
    largest, least = model.scenario.control.max_tilt, LEAST_THRUST * vehicle.mass * GRAVITY
    if limits.enabled:
        rates = np.minimum(rates, math.inf if limits.joint_rates is None else limits.joint_rates)
        largest, least = min(largest, limits.tilt), max(least, limits.min_thrust)
    actuation = model.actuation
    largest = min(largest, LEVEL) if actuation.fully else largest
    side = np.full(2 if actuation.fully else 0, actuation.side)
    tilt = [largest, largest, yaw_torque(model)]
    return Bounds(
        state_lower=np.concatenate([-free, vehicle.lower_limits]),
        state_upper=np.concatenate([free, vehicle.upper_limits]),
        input_lower=np.concatenate([[max(least, actuation.lift[0])], np.negative(tilt), -rates, -side]),
        input_upper=np.concatenate([[min(vehicle.max_thrust, actuation.lift[1])], tilt, rates, side]),
    )


def _cost(model: Model) -> QuadraticCost:
    n, scale = model.n_arm, scale_of(model)
    side = 2 if model.actuation.fully else 0
    none: Any = np.zeros(14 + n)
    hover = np.concatenate([[model.vehicle.mass * GRAVITY], np.zeros(3 + n + side)])
    weights = np.full(14 + n, STATE_WEIGHT)
    units = np.array([scale.force, 1.0, 1.0, scale.torque, *[scale.rate] * n, *[scale.force] * side])
    inputs = np.array([*INPUT_WEIGHTS, *[ARM_WEIGHT] * n, *[SIDE_COST] * side])
    return QuadraticCost(weights, weights, inputs / units**2, none, hover)
