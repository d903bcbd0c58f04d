"""Kernels of a leaf: `leaf_motion` compiled, with the numbers of a door's leaf in a record."""

from __future__ import annotations

import math

from doorman.compilation import kernel
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.leaf import leaf_motion
from doorman.numba_types.records import Record, Vector3

_turned, _way, lever = kernel(leaf_motion.turned), kernel(leaf_motion.way), kernel(leaf_motion.lever)
_leaf, _normal = kernel(leaf_motion.leaf_in_doorway), kernel(leaf_motion.normal_in_doorway)
_angle_of, _angle_of_face = kernel(leaf_motion.angle_of), kernel(leaf_motion.angle_of_face)
contact_from_hinge = kernel(leaf_motion.contact_from_hinge)


class LeafNumbers(Record):
    """What the kernels read of a door."""

    turn: float  # t of `leaf_motion`
    slide: float  # s of `leaf_motion`
    into: Vector3
    along: Vector3
    hinge: Vector3  # P_h [m]
    offset: float  # o [m]
    middle: float  # of the range of α [rad]


def leaf_numbers(door: Door) -> LeafNumbers:
    """Numbers of a door."""
    middle = 0.5 * (door.lower_limit + door.upper_limit)
    return LeafNumbers(
        turn=door.turn, slide=door.slide, into=door.into, along=door.along, hinge=door.hinge_position,
        offset=door.contact_offset, middle=middle,
    )  # fmt: skip


@kernel
def _in_world(leaf: LeafNumbers, parts: tuple[float, float]) -> tuple[float, float, float]:
    into, along = parts
    return (
        into * leaf.into[0] + along * leaf.along[0],
        into * leaf.into[1] + along * leaf.along[1],
        into * leaf.into[2] + along * leaf.along[2],
    )


@kernel
def leaf_normal(leaf: LeafNumbers, door_angle: float) -> tuple[float, float, float]:
    """n_D in the world frame: three numbers."""
    angle = _turned(leaf.turn, door_angle)
    return _in_world(leaf, _normal(math.cos(angle), math.sin(angle)))


@kernel
def leaf_direction(leaf: LeafNumbers, door_angle: float) -> tuple[float, float, float]:
    """Direction c in the world frame: three numbers; of a hinge it is also dn_D/dα."""
    angle = _turned(leaf.turn, door_angle)
    return _in_world(leaf, _leaf(math.cos(angle), math.sin(angle)))


@kernel
def leaf_before(leaf: LeafNumbers, door_angle: float) -> float:
    """How far the contact point lies before the hinge's axis, the way of a slide included [m]."""
    return float(leaf.offset + _way(leaf.slide, door_angle))


@kernel
def angle_of_face(leaf: LeafNumbers, before: float, lever_length: float) -> float:
    """By how much α of a point is less if the face stands before its place [rad]."""
    return float(_angle_of_face(leaf.turn, leaf.slide, before, lever_length))


@kernel
def angle_of_point(leaf: LeafNumbers, x: float, y: float, z: float) -> float:
    """α at which a point is on the face [rad]."""
    x, y, z = x - leaf.hinge[0], y - leaf.hinge[1], z - leaf.hinge[2]
    into = x * leaf.into[0] + y * leaf.into[1] + z * leaf.into[2]
    along = x * leaf.along[0] + y * leaf.along[1] + z * leaf.along[2]
    return float(_angle_of(leaf.turn, leaf.slide, into, along, leaf.offset, leaf.middle))
