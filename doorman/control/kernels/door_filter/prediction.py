"""Prediction of `DoorFilter`: the state by the model of the hinge, and its covariance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.door_filter.memory import (
    ANGLE,
    DAMPING,
    FRICTION,
    INERTIA,
    LEVER,
    MOVING,
    PRELOAD,
    PUSH_NOISE,
    RATE,
    REST,
    STATES,
    STIFFNESS,
    TORQUE,
    TORQUE_DEVIATION,
    TORQUE_TIME,
    VEHICLE_INERTIA,
    WIND_LEVER,
    WIND_X,
    WIND_Y,
)
from doorman.control.kernels.door_filter.standing import friction_holds, stop_where_shut
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_normal, leaf_weight

Array = NDArray[np.float64]


@kernel
def predict_door(
    numbers: Array, leaf: Array, memory: Array, z: Array, p: Array, work: Array, push: float, touching: bool,
    time_step: float,
) -> None:  # fmt: skip
    r"""Move the state on by the model, and its covariance by :math:`A P A^T + Q`; A differs from 1 in three rows."""
    lever, inertia, x, y = numbers[LEVER], z[INERTIA], 0.0, 0.0
    if touching:
        inertia += numbers[VEHICLE_INERTIA]
    slip = math.tanh(z[RATE] / (0.5 * MOVING))
    x, y, _ = leaf_normal(leaf, z[ANGLE])
    x, y = numbers[WIND_LEVER] * x, numbers[WIND_LEVER] * y
    off = z[ANGLE] - numbers[REST]
    torque = z[DAMPING] * z[RATE] + z[FRICTION] * slip + z[STIFFNESS] * off + z[TORQUE]
    torque += numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE]) + x * z[WIND_X] + y * z[WIND_Y]
    acceleration = -(lever * push + torque) / inertia
    fade, share = math.exp(-time_step / numbers[TORQUE_TIME]), time_step / inertia
    stiff = z[FRICTION] * (1.0 - slip * slip) / (0.5 * MOVING)
    row = work[0]
    row[ANGLE], row[TORQUE], row[DAMPING], row[FRICTION] = (
        -share * z[STIFFNESS],
        -share,
        -share * z[RATE],
        -share * slip,
    )
    row[RATE] = 1.0 - time_step * min((z[DAMPING] + stiff) / inertia, 0.5 / time_step)
    row[STIFFNESS], row[INERTIA], row[WIND_X], row[WIND_Y] = -share * off, -share * acceleration, -share * x, -share * y
    move_covariance(p, row, work[1], time_step, fade)
    p[RATE, RATE] += time_step * (memory[PUSH_NOISE] * lever / inertia) ** 2
    p[TORQUE, TORQUE] += (1.0 - fade**2) * memory[TORQUE_DEVIATION] ** 2
    rate = z[RATE] + time_step * acceleration
    z[ANGLE] += time_step * z[RATE]
    if not touching and (rate * z[RATE] <= 0.0 or abs(rate) < 0.5 * MOVING) and friction_holds(numbers, leaf, z):
        rate = 0.0  # friction stops a free door, it does not drive it back
    z[RATE] = rate
    stop_where_shut(numbers, leaf, z)
    z[TORQUE] *= fade


@kernel
def move_covariance(p: Array, row: Array, moved: Array, time_step: float, fade: float) -> None:
    r""":math:`A P A^T` in place, with the rows of A: angle and rate times the step, `row` for the rate, `fade` for the torque."""
    for column in range(STATES):
        total = 0.0
        for k in range(STATES):
            total += row[k] * p[k, column]
        p[ANGLE, column] += time_step * p[RATE, column]
        p[RATE, column] = total
        p[TORQUE, column] *= fade
    for k in range(STATES):
        total = 0.0
        for column in range(STATES):
            total += p[k, column] * row[column]
        moved[k] = total
    for k in range(STATES):
        p[k, ANGLE] += time_step * p[k, RATE]
        p[k, RATE] = moved[k]
        p[k, TORQUE] *= fade
