"""Pushes on a door: what the rotors press with, what a hinge resists with, and the attitude that belongs to a push."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.actuation import attitude_of_force
from doorman.model import Model
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.hinge import Hinge
from doorman.planning.limits import largest_push

_AT_GOAL = 0.05
"""A door within this of the goal need not be moved [rad]."""
_PLUMB = 0.5
"""Least share of a plumb force that counts along a lever's arc."""


def rotor_force(inputs: Array, n_arm: int) -> Array:
    """Force of the rotors, of reduced inputs."""
    side = inputs[4 + n_arm :]
    return np.array([*(side if len(side) else (0.0, 0.0)), inputs[0]])


def push_along_normal(model: Model, states: Array, inputs: Array) -> Array:
    r"""Push of the rotors along the door's normal, :math:`n_D^T (f_t R e_3 - m_A g e_3)`."""
    of_rotors = [
        rotation_body_to_world(x[:3]) @ rotor_force(u, model.n_arm) for x, u in zip(states, inputs, strict=False)
    ]
    forces = np.array(of_rotors) - [0.0, 0.0, model.vehicle.weight]
    return np.asarray((forces * model.door.normals(states[: len(inputs), 3])).sum(axis=1))


def resistance(model: Model, hinge: Hinge, angle: float) -> float:
    """Torque of a hinge at rest against the way to the goal [N m]."""
    torque = hinge.torque_at_rest(angle, model.door.rest_angle) + model.door.weight_torque(angle)
    return hinge.friction + math.copysign(torque, torque * (model.goal_angle - angle))


def too_stiff(model: Model, hinge: Hinge, angle: float) -> tuple[PlanStatus, str] | None:
    """Whether a door resists by more, here or on the way to the goal, than the vehicle can push."""
    goal, lever = model.goal_angle, model.coupling.lever_length
    if abs(angle - goal) < _AT_GOAL:
        return None
    ends = (angle, goal + math.copysign(_AT_GOAL, angle - goal))
    missing = [resistance(model, hinge, end) - lever * largest_push(model, model.largest_tilt, end) for end in ends]
    if max(missing) <= 0.0:
        return None
    hardest = ends[missing.index(max(missing))]
    worst, push = resistance(model, hinge, hardest), largest_push(model, model.largest_tilt, hardest)
    words = f"the hinge resists with {worst:.2f} N m; the vehicle makes {push * lever:.2f} N m, {push:.1f} N at {lever:.2f} m"
    if model.door.slides:
        words = f"the slide resists with {model.door.torque_in_words(worst)}; the vehicle makes {push:.2f} N"
    return PlanStatus.CANNOT_OPEN, words


def leaning(model: Model, goal: Array, hinge: Hinge) -> Array:
    """A goal whose attitude leans against what the door is estimated to resist with, beyond what the scenario names.

    A cost that draws to a level vehicle lets a door creep that needs a steady push.
    """
    closer = (hinge.stiffness - model.door.stiffness) * (float(goal[3]) - model.door.rest_angle)
    push = -(hinge.disturbance + closer + model.door.weight_torque(float(goal[3]))) / model.coupling.lever_length
    if model.actuation.fully:
        return goal
    leans = goal.copy()
    leans[:2] += push_state(model, goal, push)[:2]
    return leans


def push_state(model: Model, state: Array, push: float) -> Array:
    r"""A state with the attitude that a push makes by itself, whatever else the rotors hold against.

    A plan knows of the push along n_D and of nothing else: a steady wind that the controller leans into would be taken
    for a force on the tip. So roll and pitch are those of :math:`F_n n_D + m_A g e_3`, or of a plumb force on a lever.
    """
    if model.actuation.fully:
        return state
    start, force = state.copy(), plumb(model, push, float(state[3])) + [0.0, 0.0, model.vehicle.weight]
    start[:2] = attitude_of_force(force, float(state[2]))[:2]
    return start


def plumb(model: Model, push: float, door_angle: float) -> Array:
    """Force of a tip that pushes along the normal, shape (3,), world frame [N]: a vehicle that turns a lever stays level."""
    normal = model.door.normal(door_angle)
    if not model.door.in_plane:
        return np.asarray(push * normal)
    return np.array([0.0, 0.0, push / math.copysign(max(abs(float(normal[2])), _PLUMB), float(normal[2]))])
