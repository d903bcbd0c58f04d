"""Pushes on a door: what the rotors press with, what a hinge resists with, and the attitude that belongs to a push."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.hinge import Hinge
from doorman.planning.limits import largest_push

_AT_GOAL = 0.05
"""A door within this of the goal need not be moved [rad]."""
_PLUMB = 0.5
"""Least share of a plumb force that counts along a lever's arc."""


def push_along_normal(model: Model, states: Array, inputs: Array) -> Array:
    r"""Push of the rotors along the door's normal, :math:`n_D^T (f_t R e_3 - m_A g e_3)`."""
    roll, pitch, yaw, angle = states[: len(inputs), :4].T
    door, weight = model.door, model.vehicle.weight
    normals = door.normals(angle)
    ahead = np.cos(yaw) * normals[:, 0] + np.sin(yaw) * normals[:, 1]
    left = np.cos(yaw) * normals[:, 1] - np.sin(yaw) * normals[:, 0]
    level = np.cos(roll) * np.sin(pitch) * ahead - np.sin(roll) * left
    push = inputs[:, 0] * (level + np.cos(roll) * np.cos(pitch) * normals[:, 2]) - weight * normals[:, 2]
    for k, side in enumerate(inputs[:, 4 + model.n_arm :] if model.actuation.fully else ()):
        push[k] += normals[k] @ rotation_body_to_world(states[k, :3])[:, : len(side)] @ side
    return np.asarray(push)


def resistance(model: Model, hinge: Hinge, angle: float) -> float:
    """Torque of a hinge at rest against the way to the goal [N m]."""
    torque = hinge.torque_at_rest(angle, model.door.rest_angle) + model.door.weight_torque(angle)
    return hinge.friction + math.copysign(torque, torque * (model.goal_angle - angle))


class LargestPushes:
    """Largest push of a vehicle at every angle of its door; about a vertical hinge that is one number, found once."""

    def __init__(self, model: Model) -> None:
        self._model, self._tilt = model, model.largest_tilt
        self._everywhere = largest_push(model, self._tilt) if model.door.vertical else None

    def at(self, angle: float) -> float:
        """Force on the leaf along its normal, towards the goal [N]."""
        return largest_push(self._model, self._tilt, angle) if self._everywhere is None else self._everywhere


def too_stiff(model: Model, hinge: Hinge, angle: float, largest: LargestPushes) -> tuple[PlanStatus, str] | None:
    """Whether a door resists by more, here or on the way to the goal, than the vehicle can push."""
    goal, lever = model.goal_angle, model.coupling.lever_length
    if abs(angle - goal) < _AT_GOAL:
        return None
    ends = (angle, goal + math.copysign(_AT_GOAL, angle - goal))
    missing = [resistance(model, hinge, end) - lever * largest.at(end) for end in ends]
    if max(missing) <= 0.0:
        return None
    hardest = ends[missing.index(max(missing))]
    worst, push = resistance(model, hinge, hardest), largest.at(hardest)
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
    start, yaw, force = state.copy(), float(state[2]), plumb(model, push, float(state[3]))
    forward = math.cos(yaw) * force[0] + math.sin(yaw) * force[1]
    left = math.cos(yaw) * force[1] - math.sin(yaw) * force[0]
    weight = model.vehicle.weight + force[2]
    start[0] = math.atan2(-left, math.hypot(forward, weight))
    start[1] = math.atan2(forward, weight)
    return start


def plumb(model: Model, push: float, door_angle: float) -> Array:
    """Force of a tip that pushes along the normal, shape (3,), world frame [N]: a vehicle that turns a lever stays level."""
    normal = model.door.normal(door_angle)
    if not model.door.in_plane:
        return np.asarray(push * normal)
    return np.array([0.0, 0.0, push / math.copysign(max(abs(float(normal[2])), _PLUMB), float(normal[2]))])
