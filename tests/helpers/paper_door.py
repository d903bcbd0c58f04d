"""The shipped door by the paper's words: x through the doorway, y along the closed leaf, α = π/2 closed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def leaf_direction(door_angle: float) -> Array:
    """[cos α, sin α, 0], along the leaf from hinge to latch."""
    return np.array([math.cos(door_angle), math.sin(door_angle), 0.0])


def door_normal(door_angle: float) -> Array:
    """[sin α, −cos α, 0], the leaf's normal that points away from the vehicle."""
    return np.array([math.sin(door_angle), -math.cos(door_angle), 0.0])
