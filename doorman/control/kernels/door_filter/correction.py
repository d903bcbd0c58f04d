"""Correction of `DoorFilter` by the measured angle of the tip."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.door_filter.memory import (
    ANGLE,
    ANGLE_NOISE,
    DAMPING,
    HEAVIEST,
    INERTIA,
    LIGHTEST,
    RATE,
    SEALED,
    STATES,
    TORQUE,
)

Array = NDArray[np.float64]


@kernel
def correct_door(numbers: Array, memory: Array, z: Array, p: Array, work: Array, tip_angle: float, age: float) -> None:
    """Correct the state by the angle as it was `age` ago, in Joseph's form, which holds for any gain."""
    spread, gain, noise = work[0], work[1], numbers[ANGLE_NOISE] ** 2
    for k in range(STATES):
        spread[k] = p[k, ANGLE] - age * p[k, RATE]
    variance = spread[ANGLE] - age * spread[RATE] + noise
    off = tip_angle - (z[ANGLE] - age * z[RATE])
    for k in range(STATES):
        gain[k] = 0.0 if k > TORQUE and math.isfinite(memory[SEALED]) else spread[k] / variance
        z[k] += gain[k] * off
    for k in range(DAMPING, INERTIA):
        z[k] = max(z[k], 0.0)
    z[INERTIA] = min(max(z[INERTIA], numbers[LIGHTEST]), numbers[HEAVIEST])
    for column in range(STATES):
        seen = p[ANGLE, column] - age * p[RATE, column]
        for k in range(STATES):
            p[k, column] -= gain[k] * seen
    for k in range(STATES):
        seen = p[k, ANGLE] - age * p[k, RATE]
        for column in range(STATES):
            p[k, column] += gain[column] * (noise * gain[k] - seen)
    for k in range(STATES):
        for column in range(k):
            p[k, column] = p[column, k] = 0.5 * (p[k, column] + p[column, k])
