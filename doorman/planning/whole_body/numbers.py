"""Numbers of the whole-body problem, by the names that its task knows them by.

All that changes in flight is a number: wind, hinge, where the tip sticks, references and weights. Nothing is compiled anew.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import BackendError
from doorman.kinematics.contact import Contact
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.balance import balance_numbers
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.model import Model
from doorman.planning.pace import RESTING, STIFFNESS, Pace

_YAW_SHARE, _SHIPPED_YAW_TORQUE = 0.65, 0.19
"""Share of the rotors' torque about the vertical that plans count on, as tilting takes the rest. Where no rotor is known, the
torque of the shipped vehicle [N m]."""
ARM_WEIGHT = 50.0
"""Weight of joint rates beside the one that keeps step with the leaf, for the shipped vehicle. Cheaper arms rattle the tip:
with a tenth of this, forces above 4.5 N grow to oscillations."""
_THRUST, _THRUST_TIED = 0.3, 2.0
"""Weight of thrust beside what holds vehicle and leaf, of the shipped vehicle, of a tip that presses and of one that is tied.
Rotors do not follow cheap thrust. A tied tip bears what thrust lifts: cheaper thrust swings against the pitch where the attitude
loop is not as it is believed."""
_PLACE = np.array([40.0, 200.0])
"""Weights of where a tip that presses is on the face, along and up, for the shipped vehicle: thrust acts at once, and holds the
height against the tip's friction within 5 cm; to the side the attitude loop is in between."""
SIDE_WEIGHT, LEVEL_WEIGHT = 0.3, 300.0
"""Weights of a change of the force to the side, and of roll and pitch where a tilt gains nothing, for the shipped vehicle: of a
fully actuated vehicle, and of one that holds a lever, on which forces along the lever and along its axis do nothing."""
_NARROW = 0.005
"""Half of the narrowest face that a tip is kept on: poses are not better [m]."""
_DAMPING = 50.0
"""Damping of a tip that presses, of the shipped vehicle [N s/m]."""
_RESOLVED, _LOAD = 0.8, 0.05
"""Stiffness of a contact that a step resolves, times mobility and the step's square, and the weight of what the gripper carries
in the plane of the face, for the shipped vehicle: it may turn the vehicle, but does not move the leaf."""
_TILTING, _TILTING_TIED = 300.0, 1000.0
"""Weight of how far a commanded tilt is ahead of the tilt, of a tip that presses and of one that is tied: a pitch lifts the
tied tip, and the leaf bears it. A quick loop turns by the same error at a higher rate: there the rate
that is commanded is weighed."""


def whole_body_numbers(model: Model, contact: Contact | None = None) -> Numbers:
    """Numbers of a scenario's task, by the names that `WholeBodyTask` knows them by: its tip, or another, touches and opens."""
    vehicle, scenario, contact = model.vehicle, model.scenario, contact or model.contact
    start, goal = model.start_state, model.goal_state
    scale, free = model.scale, 1.0 - contact.tied
    slope = (start - goal) / (start[3] - goal[3])
    pace, (stiffness, damping) = Pace.of(model), _compliance(model, contact)
    gains_nothing = max(float(model.actuation.fully), contact.tied * float(model.door.in_plane))
    return model.reduced.numbers.and_also({
        **balance_numbers(vehicle), **_side_numbers(model),
        "vehicle.yaw_inertia": yaw_inertia(model),
        **loop_numbers(model, model.attitude_loop), "vehicle.tilt_offset": np.zeros(2),
        "vehicle.wind": np.zeros(3),
        "door.friction_rate": 0.02 * scale.rate, "door.disturbance": 0.0, "door.sticks": 0.0,
        "contact.stiffness": stiffness, "contact.damping": damping,
        "contact.smoothing": 1e-3 * scale.length,
        "contact.friction": scenario.contact.friction,
        "contact.stick": np.zeros(2), "contact.give": 0.004 * scale.length,
        "contact.slip_damping": contact.between(10.0 * scale.damping, damping), "contact.tied": contact.tied,
        "limits.margin": scenario.planner.margin, "limits.force": scenario.control.max_push,
        "reference.joint": goal[3], "reference.sense": math.copysign(1.0, goal[3] - start[3]),
        "reference.position": np.zeros(3), "reference.heading": [goal[2], slope[2]],
        "reference.arm": goal[5:], "reference.arm_slope": slope[5:],
        "reference.depth": 0.02 * scale.length, "reference.approach_speed": 0.08 * scale.speed,
        "reference.approach_length": 0.08 * scale.length,
        "reference.opening_speed": pace.rate, "reference.deceleration": pace.acceleration,
        "reference.settling": pace.settling, "reference.force": 0.0,
        "reference.least_force": free * RESTING * scale.force,
        "reference.turned": np.zeros(2), "reference.room": 0.03 * scale.length,
        "reference.thrust": vehicle.weight, "weights.thrust": contact.between(_THRUST, _THRUST_TIED) / scale.force**2,
        "plan.time_step": scenario.planner.time_step,
        "weights.near": 300.0 / scale.length**2,
        "weights.place": free * np.maximum(_PLACE / scale.length**2, _room(model) ** -2.0),
        "weights.position": 0.0, "weights.heading": 16.0,
        "weights.arm": 30.0, "weights.arm_rate": ARM_WEIGHT / scale.rate**2,
        "weights.approach": free * 1000.0 / scale.speed**2, "weights.opening": 100.0 / scale.rate**2,
        "weights.force": 0.0, "weights.least_force": 0.0, "weights.load": contact.tied * _LOAD / scale.force**2,
        "weights.level": LEVEL_WEIGHT * gains_nothing,
        "weights.velocity_in_world": 0.3 / scale.speed**2,
        "weights.turning": 0.5 / scale.rate**2,
    })  # fmt: skip


def _room(model: Model) -> Array:
    """How far the tip may slip on its face, along and up: to the nearest edge, where the face has one near [m]."""
    door, (along, up) = model.door, (model.coupling.distance_from_hinge, model.coupling.height)
    if door.slides:
        return np.full(2, math.inf)
    return np.maximum([door.width - along, min(up, door.height - up)], _NARROW)


def _compliance(model: Model, contact: Contact) -> tuple[float, float]:
    r"""Stiffness [N/m] and damping [N s/m] of the contact.

    A gripper is as stiff as a step of the plan resolves, and a tip that presses no stiffer, with the mass m that the tip
    feels; a tip that is not tied, g = 0, presses past the vehicle's heading and does not turn it:

    .. math:: k \le 0.8\,m/h^2,\quad c \le \sqrt{k m},\quad 1/m = 1/m_A + g\,|d|^2/I_z + D^2/I_D
    """
    tip, step = model.vehicle.tip_position(model.start_arm), model.scenario.planner.time_step
    lever, vehicle, scale = model.coupling.lever_length, model.vehicle, model.scale
    turned = contact.tied * float(tip @ tip) / yaw_inertia(model)
    mobility = 1.0 / vehicle.mass + turned + lever**2 / model.door.inertia
    stiffest = _RESOLVED / (mobility * step**2)
    stiffness = contact.between(min(STIFFNESS * scale.stiffness, stiffest), stiffest)
    damping = math.sqrt(stiffness / mobility)
    return stiffness, min(contact.between(_DAMPING * scale.damping, damping), damping)


def goal_numbers(model: Model, door_angle: float) -> dict[str, Any]:
    """Numbers of another place on the way, by name, at which the leaf is to come to rest, with the posture that belongs to it."""
    start, goal, there = model.start_state, model.goal_state, model.on_the_way(door_angle)
    return {
        "reference.joint": there[3],
        "reference.heading": [there[2], (start[2] - goal[2]) / (start[3] - goal[3])],
        "reference.arm": there[5:],
    }


def _side_numbers(model: Model) -> dict[str, Any]:
    """Numbers of a fully actuated vehicle: its force to the side now, the weight of a change of that, and its rotors."""
    rotors = model.actuation.rotors
    if rotors is None:
        return {}
    weight = {"actuation.side_weight": SIDE_WEIGHT / model.scale.force**2}
    return {"actuation.side": np.zeros(2), **weight, **rotors.numbers}


def yaw_torque(model: Model) -> float:
    """Largest torque about the vertical that a plan counts on: a share of what the rotors have to spare around hover."""
    try:
        layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
    except BackendError:
        return _SHIPPED_YAW_TORQUE * model.scale.torque
    hover = layout.inverse[:, 0] * model.vehicle.weight
    spare = np.clip(layout.max_thrusts - hover, 0.0, hover)
    return float(_YAW_SHARE * np.abs(layout.allocation[3]) @ spare)


def yaw_inertia(model: Model) -> float:
    """I_z of vehicle and arm in the goal's posture, about the vertical through the centre of mass [kg m²]."""
    center = model.vehicle.center_of_mass(model.goal_arm)
    return float(model.vehicle_inertia[2, 2] - model.vehicle.mass * center[:2] @ center[:2])


def tilt_stiffness(model: Model, loop: AttitudeLoop | None = None) -> Array:
    """Torque with which a loop, the vehicle's if none is given, answers a tilt about the body's x and y axis [N m/rad]."""
    return np.asarray((loop or model.attitude_loop).stiffness * model.vehicle_inertia.diagonal()[:2])


def loop_numbers(model: Model, loop: AttitudeLoop) -> dict[str, Any]:
    """Numbers of an attitude loop, by name, and how dear a tilt is that is ahead of it."""
    loop = loop.planned(model.scenario.planner.time_step)
    return {
        "vehicle.attitude_gain": loop.gain, "vehicle.rate_gain": loop.rate_gain,
        "vehicle.tilt_stiffness": tilt_stiffness(model, loop),
        "weights.tilting": model.contact.between(_TILTING, _TILTING_TIED) * max(loop.quickness, 1.0) ** 2,
    }  # fmt: skip
