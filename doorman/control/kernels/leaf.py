r"""Kernels of a leaf's normal and of its weight, from a flat vector of what `LeafMotion` knows.

A hinge has :math:`n = \sin\alpha\,i - \cos\alpha\,a`, a slide :math:`n = i`; c is the leaf's direction,
:math:`\cos\alpha\,i + \sin\alpha\,a` or a.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.kinematics.door import Door

Array = NDArray[np.float64]

SLIDES, OPENS, PER_ANGLE, INTO, ALONG, WEIGHT, BALANCED = 0, 1, 2, 3, 6, 9, 11
"""Places in the vector: whether it is a slide, sense of α as the door opens, `per_angle`, i, a, `weight`, and whether no weight
acts."""


def leaf_numbers(door: Door) -> Array:
    """What the kernels read of a door, shape (12,).

    Args:
        door: The door.
    """
    opens = door.opening_of(0.5 * math.pi + 1.0) / door.per_angle
    return np.array(
        [door.slides, opens, door.per_angle, *door.into, *door.along, *door.weight, door.vertical], dtype=np.float64
    )


@kernel
def leaf_normal(leaf: Array, door_angle: float) -> tuple[float, float, float]:
    """n_D in the world frame: three numbers.

    Args:
        leaf: What `leaf_numbers` returns.
        door_angle: α [rad].
    """
    into, along = 1.0, 0.0
    if leaf[SLIDES] == 0.0:
        into, along = math.sin(door_angle), -math.cos(door_angle)
    return (
        into * leaf[INTO] + along * leaf[ALONG],
        into * leaf[INTO + 1] + along * leaf[ALONG + 1],
        into * leaf[INTO + 2] + along * leaf[ALONG + 2],
    )


@kernel
def leaf_weight(leaf: Array, door_angle: float) -> float:
    """G(α) of the leaf's weight, in the sense of damping [N m].

    Args:
        leaf: What `leaf_numbers` returns.
        door_angle: α [rad].
    """
    if leaf[BALANCED] != 0.0:
        return 0.0
    if leaf[SLIDES] != 0.0:
        return float(-leaf[WEIGHT] * leaf[INTO + 2])
    s, c = math.sin(door_angle), math.cos(door_angle)
    leaf_up = c * leaf[INTO + 2] + s * leaf[ALONG + 2]
    normal_up = s * leaf[INTO + 2] - c * leaf[ALONG + 2]
    return float(leaf[WEIGHT + 1] * leaf_up - leaf[WEIGHT] * normal_up)
