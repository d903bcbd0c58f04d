"""A leaf that stands: how it is followed, what holds it, and what a seal hides as it comes loose."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.door_filter.memory import (
    ANGLE,
    FRICTION,
    LEVER,
    PRELOAD,
    RATE,
    REST,
    SEALED,
    STATES,
    STIFFNESS,
    STOOD,
    STOP,
    TORQUE,
    TORQUE_DEVIATION,
)
from doorman.kinematics.doors.leaf.leaf_kernels import OPENS, PER_ANGLE, leaf_weight

Array = NDArray[np.float64]

_LONGEST_STEP = 0.02
"""A longer period, of a controller that was held up, is followed in parts [s]."""
_STUCK_RATE = 8.0
"""Bandwidth with which a standing door's angle is followed [rad/s]."""
_STUCK_ANGLE, _STUCK_SPEED = 0.002, 0.01
"""Deviations of angle and rate that are followed so, where they do not lag [rad], [rad/s]."""
_SEAL, _UNSEALED = 2.0, 0.05
"""A leaf that comes loose under more than its hinge should resist with, by so many deviations, is sealed or latched. For so far
what it resists with says nothing of the hinge [rad]."""


@kernel
def friction_holds(numbers: Array, leaf: Array, z: Array) -> bool:
    """Whether friction holds a free door that stands."""
    known = numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE])
    return bool(z[FRICTION] > abs(z[STIFFNESS] * (z[ANGLE] - numbers[REST])) + abs(known))


@kernel
def follow_standing(z: Array, p: Array, tip_angle: float, age: float, time_step: float) -> None:
    """Follow the tip on a standing door, and leave the parameters alone.

    Where the door comes loose, angle and rate lag behind, and as much as they lag they are uncertain together; to take
    the rate's lag for motion would make the leaf light. The tip's angle is that of `age` ago besides.
    """
    parts = math.ceil(time_step / _LONGEST_STEP)
    step, off = time_step / parts, 0.0
    for _ in range(parts):
        off = tip_angle - z[ANGLE]
        z[ANGLE] += step * (z[RATE] + 2.0 * _STUCK_RATE * off)
        z[RATE] += step * _STUCK_RATE**2 * off
    lag = abs(off)
    lag_of_rate = 2.0 * _STUCK_RATE * lag
    lag_of_angle, old = lag + age * lag_of_rate, age * _STUCK_SPEED
    for row in range(RATE + 1):
        for column in range(STATES):
            p[row, column] = p[column, row] = 0.0
    p[ANGLE, ANGLE] = lag_of_angle**2 + _STUCK_ANGLE**2 + old**2
    p[RATE, RATE] = lag_of_rate**2 + _STUCK_SPEED**2
    p[ANGLE, RATE] = p[RATE, ANGLE] = lag_of_angle * lag_of_rate + old * _STUCK_SPEED


@kernel
def come_loose(numbers: Array, leaf: Array, memory: Array, z: Array, p: Array, push: float) -> None:
    """Notice a seal as the leaf begins to move, and notice the end of the seal."""
    if memory[STOOD] != 0.0:
        memory[STOOD] = 0.0
        known = numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE])
        bears = abs(numbers[LEVER] * push + known + z[STIFFNESS] * (z[ANGLE] - numbers[REST]))
        deviation = math.sqrt(max(p[FRICTION, FRICTION], 0.0))
        if bears > z[FRICTION] + _SEAL * deviation + memory[TORQUE_DEVIATION]:
            memory[SEALED] = z[ANGLE]
            p[TORQUE, TORQUE] = bears**2
    elif math.isfinite(memory[SEALED]) and abs(z[ANGLE] - memory[SEALED]) > _UNSEALED:
        memory[SEALED], z[TORQUE] = -math.inf, 0.0
        for k in range(STATES):
            p[TORQUE, k] = p[k, TORQUE] = 0.0
        p[TORQUE, TORQUE] = memory[TORQUE_DEVIATION] ** 2


@kernel
def stop_where_shut(numbers: Array, leaf: Array, z: Array) -> None:
    """Stop a door that its closer or its weight presses shut where it shuts no farther."""
    known = numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE])
    if known != 0.0 and leaf[OPENS] * leaf[PER_ANGLE] * (z[ANGLE] - numbers[STOP]) < 0.0:
        z[ANGLE], z[RATE] = numbers[STOP], 0.0
