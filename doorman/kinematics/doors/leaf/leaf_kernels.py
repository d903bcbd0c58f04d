"""Kernels of a leaf: `leaf_motion` compiled, with what a door's leaf has for numbers in a flat vector."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.leaf import leaf_motion

TURN, SLIDE, INTO, ALONG, HINGE, OFFSET, MIDDLE = 0, 1, 2, 5, 8, 11, 12
"""Places in the vector: t and s of `leaf_motion`, i, a, P_h, `contact_offset`, and the middle of the range of α."""

_turned, _way, lever = kernel(leaf_motion.turned), kernel(leaf_motion.way), kernel(leaf_motion.lever)
_leaf, _normal = kernel(leaf_motion.leaf_in_doorway), kernel(leaf_motion.normal_in_doorway)
_angle_of, _angle_of_face = kernel(leaf_motion.angle_of), kernel(leaf_motion.angle_of_face)
contact_from_hinge = kernel(leaf_motion.contact_from_hinge)


def leaf_numbers(door: Door) -> Array:
    """What the kernels read of a door, shape (13,)."""
    middle = 0.5 * (door.lower_limit + door.upper_limit)
    axes = *door.into, *door.along
    return np.array([door.turn, door.slide, *axes, *door.hinge_position, door.contact_offset, middle], dtype=np.float64)


@kernel
def _in_world(leaf: Array, parts: tuple[float, float]) -> tuple[float, float, float]:
    into, along = parts
    return (
        into * leaf[INTO] + along * leaf[ALONG],
        into * leaf[INTO + 1] + along * leaf[ALONG + 1],
        into * leaf[INTO + 2] + along * leaf[ALONG + 2],
    )


@kernel
def leaf_normal(leaf: Array, door_angle: float) -> tuple[float, float, float]:
    """n_D in the world frame: three numbers."""
    angle = _turned(leaf[TURN], door_angle)
    return _in_world(leaf, _normal(math.cos(angle), math.sin(angle)))


@kernel
def leaf_direction(leaf: Array, door_angle: float) -> tuple[float, float, float]:
    """Direction c in the world frame: three numbers; of a hinge it is also dn_D/dα."""
    angle = _turned(leaf[TURN], door_angle)
    return _in_world(leaf, _leaf(math.cos(angle), math.sin(angle)))


@kernel
def leaf_before(leaf: Array, door_angle: float) -> float:
    """How far the contact point lies before the hinge's axis, the way of a slide included [m]."""
    return float(leaf[OFFSET] + _way(leaf[SLIDE], door_angle))


@kernel
def angle_of_face(leaf: Array, before: float, lever_length: float) -> float:
    """By how much α of a point is less if the face stands before its place [rad]."""
    return float(_angle_of_face(leaf[TURN], leaf[SLIDE], before, lever_length))


@kernel
def angle_of_point(leaf: Array, x: float, y: float, z: float) -> float:
    """α at which a point is on the face [rad]."""
    x, y, z = x - leaf[HINGE], y - leaf[HINGE + 1], z - leaf[HINGE + 2]
    into = x * leaf[INTO] + y * leaf[INTO + 1] + z * leaf[INTO + 2]
    along = x * leaf[ALONG] + y * leaf[ALONG + 1] + z * leaf[ALONG + 2]
    return float(_angle_of(leaf[TURN], leaf[SLIDE], into, along, leaf[OFFSET], leaf[MIDDLE]))
