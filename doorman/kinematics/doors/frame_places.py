"""Where a tip can touch what stands beside a door: the wall or a post on either side, and the inner side of the hinge's post."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array, frozen
from doorman.exceptions import ScenarioError
from doorman.kinematics.doors.door import AT_ITS_STOP, Door
from doorman.kinematics.doors.urdf.beside import Box, boxes_along, fixed_boxes
from doorman.scenario import Scenario

_BORDER = 0.01
"""A box that reaches no farther into the doorway stands beside it [m]."""
_ROOM = 0.03
"""Least distance of a place from the edges of its face; of a tip in the doorway from the leaf behind it [m]."""
_TURN = math.radians(12.0)
"""By which the arm points at a face beside it: the tip, and not the rod, meets that."""
_AHEAD = 0.05
"""Least distance of rotor disc and wall [m]."""
_DEPTH = 0.6
"""Depth of the tip in the doorway, as a share of its distance ahead of the rotor disc: the disc stays before the frame."""
_FARTHEST = 0.4
"""From the edge nearer to the doorway: the vehicle does not fly farther along a long wall [m]."""


@dataclass(frozen=True, eq=False)
class FramePlace:
    """A place where the tip meets the frame of a door that stands where the map has it."""

    point: Array
    """Shape (3,), world frame [m]."""
    normal: Array
    """Unit vector into the face, shape (3,), world frame."""
    room: float
    """By which the tip may be aside of the point and still meet the face [m]."""
    clear: float
    """Between rotor disc and frame, with the tip there [m]."""
    turn: float = 0.0
    """By which the arm is turned from straight ahead [rad]."""


def frame_places(door: Door, height: float, reach: float, radius: float) -> tuple[FramePlace, ...]:
    """Places that tell where a door stands: two on its front far apart, and one beside the hinge, where the frame is deep enough.

    The front has its place on the widest box on either side. A wider face bears a larger error of the map along it.
    """
    if not (door.upright and door.vertical):
        return ()
    drawn = boxes_along(fixed_boxes(door.urdf, door.model), door.axes, door.hinge_position)
    boxes = [box for box in drawn if abs(box.center[2] - height) < box.half[2] - _ROOM]
    sides = (
        [box for box in boxes if box.ends[1] < _BORDER],
        [box for box in boxes if box.ends[0] > door.width - _BORDER],
    )
    front = [_on_the_front(side, towards) for side, towards in zip(sides, (1.0, -1.0), strict=True)]
    if None in front:
        return ()
    ahead = reach * math.cos(_TURN) - radius
    beside = _beside_the_hinge(sides[0], _DEPTH * ahead, -door.contact_offset)
    clear = reach - radius
    places = [_place(door, at, height, door.into, clear) for at in (front[1], front[0]) if at is not None]
    if beside is not None:
        clear = (1.0 - _DEPTH) * ahead
        places.append(_place(door, (beside, 0.0, _ROOM), height, -door.along, clear, -door.hand * _TURN))
    return tuple(places)


def places_to_touch(
    scenario: Scenario, door: Door, height: float, reach: float, radius: float, opening: float
) -> tuple[FramePlace, ...]:
    """The places that a mission is to touch."""
    if "frame" not in scenario.mission.measures:
        return ()
    places = frame_places(door, height, reach, radius)
    reasons = {
        'contact.kind = "push": a grip finds the door on its arc': scenario.contact.kind == "push",
        'mission.start = "hover"': scenario.mission.start == "hover",
        "a leaf that starts closed": abs(opening) < AT_ITS_STOP,
        f"a start.arm that reaches {1e2 * _AHEAD:g} cm ahead of the rotor disc": reach > radius + _AHEAD,
        "a deviation of the map above 0": scenario.estimation.door_place_deviation > 0.0,
        "a plumb hinge, with a wall or a post on both sides of the leaf at the height of the tip": bool(places),
    }
    if missing := [reason for reason, holds in reasons.items() if not holds]:
        raise ScenarioError(
            "the tip cannot touch the frame", file=scenario.source, field="mission.measures", given="frame",
            allowed=f"only with {missing[0]}",
        )  # fmt: skip
    return places


def _place(
    door: Door, at: tuple[float, float, float], height: float, normal: Array, clear: float, turn: float = 0.0
) -> FramePlace:
    into, along, room = at
    point = door.hinge_position + door.from_doorway(np.array([into, along, height]))
    return FramePlace(frozen(point), frozen(normal), room, clear, turn)


def _on_the_front(side: list[Box], towards: float) -> tuple[float, float, float] | None:
    """Place on the widest face of one side, along `into` and `along`, and the room about it [m]."""
    for box in sorted(side, key=lambda box: -float(box.half[1])):
        along = float(box.center[1] + towards * max(box.half[1] - _FARTHEST, 0.0))
        behind = any(
            other.front < box.front and other.ends[0] - _ROOM < along < other.ends[1] + _ROOM for other in side
        )
        if box.half[1] > _ROOM and not behind:
            return box.front, along, max(min(float(box.half[1]), _FARTHEST) - _ROOM, _ROOM)
    return None


def _beside_the_hinge(side: list[Box], depth: float, face: float) -> float | None:
    """How far a tip is in the doorway beside the hinge's post, between its front and the leaf, along `into` [m]."""
    fronts = [box.front for box in side if abs(box.ends[1]) < _BORDER]
    into = min(fronts, default=0.0) + depth
    return into if fronts and depth > _ROOM and into < face - _ROOM else None
