"""Numbers of the whole-body problem, by the names that its task knows them by.

All that changes in flight is a number: wind, hinge, where the tip sticks, references and weights. Nothing is compiled anew.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import BackendError
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.balance import balance_numbers
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.model import Model
from doorman.planning.pace import Pace

Array = NDArray[np.float64]

_YAW_SHARE, _SHIPPED_YAW_TORQUE = 0.65, 0.25
"""Share of the rotors' torque about the vertical, around half thrust, that plans count on, as tilting takes
the rest. Where no rotor is known, the torque of the shipped vehicle [N m]."""
ARM_WEIGHT = 50.0
"""Of every joint rate beside the one that keeps step with the leaf, of the shipped vehicle. Cheaper arms rattle the tip: with a
tenth of this, pushes above 4.5 N grow to oscillations."""
_LARGEST_FORCE, _STIFFNESS = 15.0, 1500.0
"""Of the tip on the leaf, and of the contact that plans count on, for the shipped vehicle [N], [N/m]."""
SIDE_WEIGHT, LEVEL_WEIGHT = 0.3, 300.0
"""Of a change of the force to the side, of the shipped vehicle, and of roll and pitch, of a fully actuated vehicle."""
_ROOM = (0.03, 1e3, 1.0, 1.0)
"""By which rows are widened for the shipped vehicle: planes, force, speed and stopping. Noise moves a start across tight rows,
and plans of one iteration do not converge there; residuals keep the distance instead."""


def whole_body_numbers(model: Model) -> Numbers:
    """Numbers of a scenario's task, by the names that `WholeBodyTask` knows them by: the tip touches and opens."""
    vehicle, scenario = model.vehicle, model.scenario
    start, goal = model.start_state, model.goal_state
    scale = model.scale
    slope = (start - goal) / (start[3] - goal[3])
    balance, pace = balance_numbers(vehicle), push_pace(model)
    before = len(vehicle.point_names) + len(balance.get("balance.reaches", ()))
    return model.reduced.numbers.and_also({
        **balance, **_side_numbers(model),
        "vehicle.yaw_inertia": yaw_inertia(model),
        "vehicle.attitude_gain": model.attitude_loop.gain, "vehicle.rate_gain": model.attitude_loop.rate_gain,
        "vehicle.tilt_stiffness": tilt_stiffness(model), "vehicle.tilt_offset": np.zeros(2),
        "vehicle.wind": np.zeros(3),
        "door.friction_rate": 0.02 * scale.rate, "door.disturbance": 0.0, "door.sticks": 0.0,
        "contact.stiffness": _STIFFNESS * scale.stiffness, "contact.damping": 50.0 * scale.damping,
        "contact.smoothing": 1e-3 * scale.length,
        "contact.friction": scenario.contact.friction,
        "contact.stick": np.zeros(2), "contact.give": 0.004 * scale.length,
        "contact.slip_damping": 10.0 * scale.damping,
        "limits.margin": scenario.planner.margin, "limits.force": _LARGEST_FORCE * scale.force,
        "limits.speed": pace.rate, "limits.deceleration": 0.0, "limits.rounding": 0.01,
        "limits.creep": 0.5 * (0.015 * scale.rate) ** 2,
        "limits.widened": np.concatenate([np.zeros(before), *_room_of_rows(model)]),
        "reference.joint": goal[3], "reference.sense": math.copysign(1.0, goal[3] - start[3]),
        "reference.position": np.zeros(3), "reference.heading": [goal[2], slope[2]],
        "reference.arm": goal[5:], "reference.arm_slope": slope[5:],
        "reference.depth": 0.02 * scale.length, "reference.approach_speed": 0.08 * scale.speed,
        "reference.approach_length": 0.08 * scale.length,
        "reference.opening_speed": pace.rate, "reference.deceleration": pace.acceleration,
        "reference.settling": pace.settling, "reference.force": 0.0,
        "reference.least_force": 0.5 * scale.force, "reference.largest_force": 12.0 * scale.force,
        "reference.turned": np.zeros(2), "reference.room": 0.03 * scale.length,
        "plan.time_step": scenario.planner.time_step,
        "weights.near": 300.0 / scale.length**2,
        "weights.place": 40.0 / scale.length**2, "weights.position": 0.0, "weights.heading": 16.0,
        "weights.arm": 30.0, "weights.arm_rate": ARM_WEIGHT / scale.rate**2,
        "weights.approach": 1000.0 / scale.speed**2, "weights.opening": 100.0 / scale.rate**2,
        "weights.force": 0.0, "weights.least_force": 0.0,
        "weights.largest_force": 1.0 / scale.force**2, "weights.tilting": 300.0,
        "weights.velocity_in_world": 0.3 / scale.speed**2, "weights.turning": 0.5 / scale.rate**2,
    })  # fmt: skip


def push_pace(model: Model, safe: bool = False) -> Pace:
    """Of a leaf that is pushed: one that is stopped is hit with no more than a plan may press."""
    return Pace.of(model, _LARGEST_FORCE * model.scale.force, _STIFFNESS * model.scale.stiffness, safe)


def _room_of_rows(model: Model) -> tuple[Array, Array]:
    """By how much rows are widened: the planes, and force, speed and stopping."""
    scale, planes = model.scale, model.n_constraints - len(model.vehicle.point_names)
    units = np.array([scale.force, scale.rate, scale.rate**2])
    return np.full(planes, _ROOM[0] * scale.length), np.array(_ROOM[1:]) * units


def _side_numbers(model: Model) -> dict[str, Any]:
    """Of a fully actuated vehicle: its force to the side now, how dear a change of that and tilt are, and its rotors."""
    rotors = model.actuation.rotors
    if rotors is None:
        return {}
    weights = {
        "actuation.side_weight": SIDE_WEIGHT / model.scale.force**2,
        "actuation.level_weight": LEVEL_WEIGHT,
    }
    return {"actuation.side": np.zeros(2), **weights, **rotors.numbers}


def yaw_torque(model: Model) -> float:
    """Largest torque about the vertical that a plan counts on: a share of what the rotors make around half thrust."""
    try:
        layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
    except BackendError:
        return _SHIPPED_YAW_TORQUE * model.scale.torque
    return float(_YAW_SHARE * layout.torque_authority[2])


def yaw_inertia(model: Model) -> float:
    """I_z of vehicle and arm in the goal's posture, about the vertical through the centre of mass [kg m²]."""
    center = model.vehicle.center_of_mass(model.goal_arm)
    return float(model.vehicle_inertia[2, 2] - model.vehicle.mass * center[:2] @ center[:2])


def tilt_stiffness(model: Model) -> Array:
    """Torque with which the vehicle's attitude loop answers a tilt about the body's x and y axis [N m/rad]."""
    return np.asarray(model.attitude_loop.stiffness * model.vehicle_inertia.diagonal()[:2])
