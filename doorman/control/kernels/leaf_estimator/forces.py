"""Forces and torques at the leaf that follow from the memory of `LeafEstimator`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.door_filter.memory import ANGLE, FRICTION, INERTIA, RATE, STIFFNESS
from doorman.control.kernels.hinge_step import ESTIMATE
from doorman.control.kernels.leaf_estimator.memory import (
    AHEAD,
    CLOSER,
    FORCE_SCALE,
    HINGE_SCALE,
    LEVER,
    MASS,
    REST,
    SLID,
    UP,
    LeafMemory,
)
from doorman.control.kernels.wind_step import take_unexplained
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_direction, leaf_weight

Array = NDArray[np.float64]

_LEAST = 0.2
"""Force of the shipped vehicle's tip that touches [N]."""
_CARRIED = 0.5
"""Share of the normal force that friction is believed to carry."""
MOVING = 0.02
"""A door that is faster moves, and teaches its resistance [rad/s]."""
LEAST_RESISTANCE, FIRST_RESISTANCE = 0.05, 0.3
"""Of a room door's hinge, and what is believed at first [N m]."""


@kernel
def along(direction: tuple[float, float, float], vector: Array) -> float:
    """A vector's share along a direction."""
    return float(direction[0] * vector[0] + direction[1] * vector[1] + direction[2] * vector[2])


@kernel
def pull(direction: tuple[float, float, float], wind: Array, felt: Array) -> float:
    """Wind less outer force along a direction [N]."""
    x, y, up = wind[0] - felt[0], wind[1] - felt[1], wind[2] - felt[2]
    return float(direction[0] * x + direction[1] * y + direction[2] * up)


@kernel
def least_force(e: LeafMemory) -> float:
    """Of a tip that touches [N]."""
    return float(_LEAST * e.numbers[FORCE_SCALE])


@kernel
def weight_ahead(e: LeafMemory) -> float:
    """Torque of the leaf's weight against opening [N m]."""
    return float(e.numbers[AHEAD] * leaf_weight(e.door.leaf, e.door.state[ANGLE]))


@kernel
def friction_share(e: LeafMemory) -> float:
    """Share of friction in what the hinge resists with, beside the leaf's weight."""
    z = e.door.state
    closer = max(z[STIFFNESS] * (e.numbers[REST] - z[ANGLE]), 0.0) + abs(e.numbers[CLOSER])
    slides = z[FRICTION] + LEAST_RESISTANCE * e.numbers[HINGE_SCALE]
    return float(slides / (slides + closer))


@kernel
def contact_force(
    e: LeafMemory, normal: tuple[float, float, float], felt: Array, acting: float, resistance: float, read: bool,
    time_step: float,
) -> float:  # fmt: skip
    """λ of vehicle and leaf that move as one; the wind takes what no contact explains."""
    memory, z, lever, wind = e.memory, e.door.state, e.numbers[LEVER], e.wind.state
    leaf, vehicle = z[INERTIA], e.numbers[MASS] * lever
    reaction = resistance if -z[RATE] > MOVING else max(-e.torque[ESTIMATE], 0.0)
    reaction += weight_ahead(e)
    force = max((leaf * acting + vehicle * reaction) / (leaf + vehicle * lever), least_force(e))
    aside = leaf_direction(e.door.leaf, z[ANGLE])
    up = (e.numbers[UP], e.numbers[UP + 1], e.numbers[UP + 2])
    pressed, along_leaf, upwards = pull(normal, wind, felt), pull(aside, wind, felt), pull(up, wind, felt)
    carried = _CARRIED * max(pressed, force)
    share = min(1.0, carried / max(math.hypot(along_leaf, upwards), 1e-9))
    memory[SLID], memory[SLID + 1] = share * along_leaf, share * upwards
    take_unexplained(e.wind, aside[0], aside[1], aside[2], along_leaf - memory[SLID], time_step)
    take_unexplained(e.wind, up[0], up[1], up[2], upwards - memory[SLID + 1], time_step)
    if not read:
        take_unexplained(e.wind, normal[0], normal[1], normal[2], min(pressed - least_force(e), 0.0), time_step)
    return float(force)
