"""Where tags go: on the leaf at the height of the vehicle's camera, and on the frame or wall beside the latch."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.hardware.door.config import CameraConfig, Mark
from doorman.hardware.quaternions import from_rotation, to_attitude
from doorman.kinematics.doors.door import Door
from doorman.model import Model

LEAF_TAG, FRAME_TAG = "2", "3"
_CLEAR = 0.12
"""Least distance of a tag's middle from the leaf's edges, over its own half [m]."""
_BESIDE = 0.06
"""From the leaf's edge to the frame tag's black square [m]."""


def usual_camera(field_of_view: float) -> CameraConfig:
    focal = 0.5 * CameraConfig().height / math.tan(0.5 * field_of_view)
    return CameraConfig(fx=focal, fy=focal)


def usual_marks(model: Model, size: float = 0.16, camera: CameraConfig | None = None) -> tuple[Mark, Mark]:
    """Tags for leaf and frame that the vehicle sees from its hover."""
    door, start = model.door, model.start_state
    body = model.coupling.vehicle_position(start[:3], float(start[3]), start[5:])
    lens = (camera or CameraConfig()).position[2]
    along, up = door.in_doorway(body - door.hinge_position)[1:]
    room = 0.5 * size * 1.25 + 0.01
    height = float(np.clip(up + lens, room, door.height - room))
    edge = min(_CLEAR + 0.5 * size, 0.5 * door.width)
    across = float(np.clip(along, edge, door.width - edge))
    before = door.surface_offset + door.way(model.start_angle)
    leaf = door.hinge_position + door.from_doorway(np.array([-door.surface_offset, across, height]))
    beside = door.hinge_position + door.from_doorway(
        np.array([-max(door.frame_depth, before if door.slides else 0.0), door.width + _BESIDE + 0.5 * size, height])
    )
    closed = door.link_placements(door.angle_of_opening(0.0))[door.section.leaf]
    return _mark(LEAF_TAG, closed, leaf, door, size), _mark(FRAME_TAG, door.placement, beside, door, size)


def _mark(name: str, link: Array, place: Array, door: Door, size: float) -> Mark:
    """A tag at a place in the world on the closed door's face, as its link has it."""
    out = -door.into
    right = np.cross(door.up, out)
    turn = link[:3, :3].T @ np.column_stack([right, door.up, out])
    x, y, z = (link[:3, :3].T @ (place - link[:3, 3])).tolist()
    return Mark(name, (x, y, z), to_attitude(from_rotation(turn)), size)
