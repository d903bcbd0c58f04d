"""The way through an open doorway: straight, beside the leaf, as far from everything as there is room."""

from __future__ import annotations

import itertools
import math

import numpy as np

from doorman.arrays import Array
from doorman.collision.scene import Clearance, CollisionScene
from doorman.control.way_out import ROOM, way_out
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

BEHIND = 1.0
"""Between O_B and the back of the doorway where the way ends [m]."""
NEEDED = 0.05
"""Clearance that a vehicle needs on the way, for gusts and what its controller leaves [m]."""
OFF = math.radians(2.0)
"""By which the leaf may stand off the goal [rad]."""
_BETWEEN = 0.05
"""Between places on the way at which the clearance is measured [m]."""
_TURNS = 8
"""Postures at which it is measured while the vehicle turns for the way."""
_WAYS = 13
"""Ways beside each other of which the best is taken."""


class Passage:
    """Straight way through the doorway of a door that stands at the goal.

    The vehicle flies it level with its hover before the door, heading through the doorway, its arm as at the start.
    """

    def __init__(self, model: Model) -> None:
        self._model, door = model, model.door
        forward, self._side, self._origin, width, depth = _doorway(model)
        self._forward = forward
        self.yaw = math.atan2(forward[1], forward[0])
        """Yaw of the vehicle on the way [rad]."""
        self.arm: Array = model.start_arm
        """Posture of the arm on the way, shape (n,) [rad or m]."""
        goal = model.goal_state
        self._begin = way_out(model, model.coupling.vehicle_position(goal[:3], goal[3], goal[5:]), goal[3])[-1]
        self._height = float(self._begin[2] - self._origin[2])
        self._before = -model.vehicle.radius - model.scenario.mission.hover_distance - door.frame_depth
        self._around_leaf = door.side == "pull" and not door.slides  # it stands between the vehicle and the doorway
        if self._around_leaf:
            ahead = float(np.linalg.norm(model.vehicle.tip_position(self.arm)[:2]))
            self._before = -door.width - max(model.vehicle.radius, ahead) - ROOM
        self._behind = depth + BEHIND
        self._scene = CollisionScene(model.vehicle, door)
        room = min(model.vehicle.radius, 0.5 * width)
        self.clearance, beside = max(
            ((self._clearance(at), at) for at in np.linspace(room, width - room, _WAYS)),
            key=lambda way: way[0].distance,
        )
        """Least clearance on the way, with a leaf that stands up to `OFF` off the goal."""
        *self.around, self.entrance, self.exit = self._places(beside)
        """Where the way through begins and ends, and places on the way to its beginning, of O_B, (3,) each, world frame [m]."""

    @property
    def clear(self) -> bool:
        """Whether there is room to fly through."""
        return self.clearance.distance >= NEEDED

    def into(self, position: Array) -> float:
        """How far a place is behind the closed leaf, negative before it [m]."""
        return float((position - self._origin) @ self._forward)

    def outside(self, position: Array) -> bool:
        """Whether the whole rotor disc is before the doorway."""
        return self.into(position) < -self._model.door.frame_depth - self._model.vehicle.radius

    def _places(self, beside: float) -> list[Array]:
        """Places on the way, after where it begins: round the edge of a leaf that was pulled open, entrance and exit."""
        level = self._origin + beside * self._side + np.array([0.0, 0.0, self._height])
        entrance, last = level + self._before * self._forward, level + self._behind * self._forward
        if not self._around_leaf:
            return [entrance, last]
        return [self._begin + (self._before - self.into(self._begin)) * self._forward, entrance, last]

    def _clearance(self, beside: float) -> Clearance:
        """Least on one way, from where the vehicle has come out of the door's reach."""
        places, model = [self._begin, *self._places(beside)], self._model
        way = np.vstack([_between(*ends) for ends in itertools.pairwise(places)])
        posture = model.goal_state if model.door.side == "pull" else model.start_state  # in which it has come out
        shares = np.hstack([np.linspace(0.0, 1.0, _TURNS), np.ones(len(way))])[:, None]
        positions = np.vstack([np.tile(self._begin, (_TURNS, 1)), way])
        yaws = float(posture[2]) + shares[:, 0] * math.remainder(self.yaw - float(posture[2]), 2.0 * math.pi)
        rotations = np.array([rotation_body_to_world([0.0, 0.0, yaw]) for yaw in yaws])
        arms, goal = posture[5:] + shares * (self.arm - posture[5:]), model.goal_angle
        found = [
            self._scene.min_clearance_along(positions, rotations, arms, np.full(len(positions), goal + off)).worst
            for off in (-OFF, OFF)
        ]
        return min(found, key=lambda clearance: clearance.distance)


def has_doorway(model: Model) -> bool:
    """Whether there is a doorway to fly through: behind a hinge that stands, or a slide that moves its panel to the side."""
    door = model.door
    return not door.lies if not door.slides else door.panel is not None and abs(_panel_normal(model)[2]) < 0.5


def behind_the_door(model: Model, position: Array) -> bool:
    """Whether a vehicle that flies through has got behind the doorway, with all of its disc."""
    if model.scenario.mission.then != "through" or not has_doorway(model):
        return False
    forward, _, origin, _, depth = _doorway(model)
    return float((position - origin) @ forward) > depth + model.vehicle.radius


def over_the_sill(model: Model, position: Array) -> bool:
    """Whether a vehicle that stood there would have feet in the doorway: they stand within half the radius of the disc."""
    if not has_doorway(model):
        return False
    forward, side, origin, width, depth = _doorway(model)
    into, beside, feet = (
        float((position - origin) @ forward),
        float((position - origin) @ side),
        0.5 * model.vehicle.radius,
    )
    return -model.door.frame_depth - feet < into < depth + feet and 0.0 < beside < width


def _doorway(model: Model) -> tuple[Array, Array, Array, float, float]:
    """Directions through the doorway and along the closed leaf, both level; its corner; its width and its depth behind [m]."""
    door = model.door
    if not door.slides:
        return _level(door.into), _level(door.along), door.hinge_position, door.width, door.frame_back
    forward, side = _level(-_panel_normal(model)), _level(door.into)
    return forward, side, door.hinge_position, door.thickness, door.width


def _panel_normal(model: Model) -> Array:
    """Normal of a slide's panel, towards the vehicle, shape (3,), world frame."""
    panel = model.door.panel
    assert panel is not None
    return model.door.from_doorway(panel[0])


def _level(direction: Array) -> Array:
    flat = np.array([direction[0], direction[1], 0.0])
    return np.asarray(flat / np.linalg.norm(flat))


def _between(first: Array, last: Array) -> Array:
    steps = max(2, math.ceil(float(np.linalg.norm(last - first)) / _BETWEEN))
    return first + np.linspace(0.0, 1.0, steps)[:, None] * (last - first)
