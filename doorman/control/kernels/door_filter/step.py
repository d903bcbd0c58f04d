"""One period of `DoorFilter`, and the hinge's parameters as they are known."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.door_filter.correction import correct_door
from doorman.control.kernels.door_filter.memory import (
    ANGLE,
    CLOSES,
    DAMPING,
    END,
    FRICTION,
    INERTIA,
    MOVING,
    PRELOAD,
    PUSH_IN_WIND,
    PUSH_NOISE,
    RATE,
    REST,
    SEEN,
    STATES,
    STIFFNESS,
    STOOD,
    TORQUE,
    TORQUE_DEVIATION,
    TORQUE_IN_WIND,
    TOUCHED,
    TYPICAL_WIND,
    WIND_DEVIATION,
    WIND_LEVER,
    WIND_SHARE,
    WIND_X,
    WIND_Y,
)
from doorman.control.kernels.door_filter.prediction import predict_door
from doorman.control.kernels.door_filter.standing import come_loose, follow_standing, friction_holds
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_normal, leaf_weight

Array = NDArray[np.float64]

_PAST_ITS_END = 0.05
"""A tip that is farther beyond the joint's range is beside the leaf, and not before it [rad]."""
_FELT = 0.1
"""Wind that says where it comes from [N]."""


@kernel
def advance_door(
    numbers: Array, leaf: Array, memory: Array, z: Array, p: Array, work: Array, push: float, touching: bool,
    tip_angle: float, measured_at: float, now: float, time_step: float, wind_x: float, wind_y: float,
) -> None:  # fmt: skip
    """One period of the filter."""
    if touching and memory[TOUCHED] == 0.0:
        memory[TOUCHED] = 1.0
        expect_wind(numbers, memory, z, p, wind_x, wind_y)
    if touching and abs(z[RATE]) < MOVING:
        memory[STOOD] = 1.0
        follow_standing(z, p, tip_angle, now - measured_at, time_step)
        return
    if not touching and z[RATE] == 0.0 and friction_holds(numbers, leaf, z):
        return
    felt = push if touching else 0.0
    come_loose(numbers, leaf, memory, z, p, felt)
    predict_door(numbers, leaf, memory, z, p, work, felt, touching, time_step)
    if touching and measured_at > memory[SEEN]:
        correct_door(numbers, memory, z, p, work, tip_angle, now - measured_at)
    memory[SEEN] = measured_at


@kernel
def expect_wind(numbers: Array, memory: Array, z: Array, p: Array, wind_x: float, wind_y: float) -> None:
    """Expect wind on the leaf, and gusts, as the wind on the vehicle makes them likely."""
    strength = math.hypot(wind_x, wind_y)
    memory[PUSH_NOISE] += numbers[PUSH_IN_WIND] * strength
    memory[TORQUE_DEVIATION] += numbers[TORQUE_IN_WIND] * strength
    p[TORQUE, TORQUE] = memory[TORQUE_DEVIATION] ** 2
    if strength > 0.0:
        mean = numbers[TYPICAL_WIND] + numbers[WIND_SHARE] * (strength - numbers[TYPICAL_WIND])
        share = min(strength / _FELT, 1.0) / strength
        x, y, variance = share * wind_x, share * wind_y, numbers[WIND_DEVIATION] ** 2
        z[WIND_X], z[WIND_Y] = mean * x, mean * y
        p[WIND_X, WIND_X] += variance * x * x
        p[WIND_X, WIND_Y] += variance * x * y
        p[WIND_Y, WIND_X] += variance * y * x
        p[WIND_Y, WIND_Y] += variance * y * y


@kernel
def turn_wind(z: Array, p: Array, angle: float) -> None:
    """Turn the wind on the leaf as that on the vehicle turns."""
    c, s, x, y = math.cos(angle), math.sin(angle), z[WIND_X], z[WIND_Y]
    z[WIND_X], z[WIND_Y] = c * x - s * y, s * x + c * y
    for k in range(STATES):
        a, b = p[WIND_X, k], p[WIND_Y, k]
        p[WIND_X, k], p[WIND_Y, k] = c * a - s * b, s * a + c * b
    for k in range(STATES):
        a, b = p[k, WIND_X], p[k, WIND_Y]
        p[k, WIND_X], p[k, WIND_Y] = c * a - s * b, s * a + c * b


@kernel
def pass_leaf(numbers: Array, z: Array, tip_angle: float) -> None:
    """Put a leaf that is not touched beyond the tip, wherever it was thought to be."""
    end = numbers[END]
    if end - _PAST_ITS_END < tip_angle < z[ANGLE]:
        z[ANGLE] = max(tip_angle, end)
        z[RATE] = min(z[RATE], 0.0)


@kernel
def hinge_of(numbers: Array, leaf: Array, z: Array, p: Array, out: Array) -> None:
    """Parameters of the hinge in the order of `HingeEstimate`, into `out` of shape (12,)."""
    known = abs(numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE]))
    turned = abs(numbers[REST] - z[ANGLE])
    squares = p[FRICTION, FRICTION] + turned * turned * p[STIFFNESS, STIFFNESS]
    together = 2.0 * turned * p[FRICTION, STIFFNESS]
    for k in range(DAMPING, INERTIA + 1):
        out[k - DAMPING] = z[k]
        out[k - DAMPING + 4] = math.sqrt(max(p[k, k], 0.0))
    x, y, _ = leaf_normal(leaf, z[ANGLE])
    out[8] = math.sqrt(max(squares + together, 0.0))
    out[9] = numbers[CLOSES] * numbers[WIND_LEVER] * (x * z[WIND_X] + y * z[WIND_Y])
    out[10] = z[FRICTION] - known - z[STIFFNESS] * turned
    out[11] = math.sqrt(max(squares - together, 0.0))
