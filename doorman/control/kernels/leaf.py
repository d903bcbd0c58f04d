r"""Kernels of a leaf: its normal, its weight, and the angle at which a point is on its face, from a flat vector.

A hinge has :math:`n = \sin\alpha\,i - \cos\alpha\,a`, a slide :math:`n = i`; c is the leaf's direction,
:math:`\cos\alpha\,i + \sin\alpha\,a` or a.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.kinematics.doors.door import Door

Array = NDArray[np.float64]

SLIDES, OPENS, PER_ANGLE, INTO, ALONG, WEIGHT, BALANCED, HINGE, OFFSET, MIDDLE = 0, 1, 2, 3, 6, 9, 11, 12, 15, 16
"""Places in the vector: whether it is a slide, sense of α as the door opens, `per_angle`, i, a, `weight`, whether no weight acts,
P_h, `contact_offset`, and the middle of the range of α."""


def leaf_numbers(door: Door) -> Array:
    """What the kernels read of a door, shape (17,)."""
    opens = door.opening_of(0.5 * math.pi + 1.0) / door.per_angle
    moves = door.slides, opens, door.per_angle, *door.into, *door.along, *door.weight, door.vertical
    middle = 0.5 * (door.lower_limit + door.upper_limit)
    return np.array([*moves, *door.hinge_position, door.contact_offset, middle], dtype=np.float64)


@kernel
def leaf_normal(leaf: Array, door_angle: float) -> tuple[float, float, float]:
    """n_D in the world frame: three numbers."""
    into, along = 1.0, 0.0
    if leaf[SLIDES] == 0.0:
        into, along = math.sin(door_angle), -math.cos(door_angle)
    return (
        into * leaf[INTO] + along * leaf[ALONG],
        into * leaf[INTO + 1] + along * leaf[ALONG + 1],
        into * leaf[INTO + 2] + along * leaf[ALONG + 2],
    )


@kernel
def leaf_direction(leaf: Array, door_angle: float) -> tuple[float, float, float]:
    """Direction c in the world frame: three numbers; of a hinge it is also dn_D/dα."""
    into, along = 0.0, 1.0
    if leaf[SLIDES] == 0.0:
        into, along = math.cos(door_angle), math.sin(door_angle)
    return (
        into * leaf[INTO] + along * leaf[ALONG],
        into * leaf[INTO + 1] + along * leaf[ALONG + 1],
        into * leaf[INTO + 2] + along * leaf[ALONG + 2],
    )


@kernel
def leaf_weight(leaf: Array, door_angle: float) -> float:
    """Torque G(α) of the leaf's weight, in the sense of damping [N m]."""
    if leaf[BALANCED] != 0.0:
        return 0.0
    if leaf[SLIDES] != 0.0:
        return float(-leaf[WEIGHT] * leaf[INTO + 2])
    s, c = math.sin(door_angle), math.cos(door_angle)
    leaf_up = c * leaf[INTO + 2] + s * leaf[ALONG + 2]
    normal_up = s * leaf[INTO + 2] - c * leaf[ALONG + 2]
    return float(leaf[WEIGHT + 1] * leaf_up - leaf[WEIGHT] * normal_up)


@kernel
def angle_of_point(leaf: Array, x: float, y: float, z: float) -> float:
    """α at which a point is on the face [rad]."""
    x, y, z = x - leaf[HINGE], y - leaf[HINGE + 1], z - leaf[HINGE + 2]
    into = x * leaf[INTO] + y * leaf[INTO + 1] + z * leaf[INTO + 2]
    if leaf[SLIDES] != 0.0:
        return float(0.5 * math.pi - (into + leaf[OFFSET]) / leaf[PER_ANGLE])
    along = x * leaf[ALONG] + y * leaf[ALONG + 1] + z * leaf[ALONG + 2]
    way = math.hypot(along, into)
    before = math.asin(min(max(leaf[OFFSET] / way, -1.0), 1.0)) if way > 0.0 else 0.0
    beside = math.atan2(along, into) - before - leaf[MIDDLE]
    return float(leaf[MIDDLE] + beside - 2.0 * math.pi * round(beside / (2.0 * math.pi)))
