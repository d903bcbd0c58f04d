r"""Kernel of an estimate: what the bank knew at the last pose, carried on to now, and where tip and leaf are then.

With the age a of the pose, :math:`P + a\dot P + \tfrac12 a^2\ddot P` and :math:`\alpha + a\dot\alpha`.
"""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.control.kernels.tip import ARM, ATTITUDE, BODY_RATES, POSITION, VELOCITY, tip_on_leaf
from doorman.control.kernels.under_way_step import rates_of_euler
from doorman.estimation.leaf.kernels.acting_step import find_now
from doorman.estimation.leaf.numbers import JOINT, JOINT_RATE, PLACES, SIZE
from doorman.kinematics.doors.leaf.leaf_kernels import (
    HINGE,
    angle_of_face,
    contact_from_hinge,
    leaf_before,
    leaf_direction,
    leaf_normal,
)
from doorman.kinematics.vehicles.arms.arm import ArmParameters

UP, DISTANCE = 0, 3
"""Places in where the contact is: u of the door, D_V and D_H."""
FORCE_OUT, WIND_OUT, GAIN_OUT, BORNE_OUT = 0, 1, 6, 9
"""Places among the outputs of the bank at the leaf."""
FACE, FRICTION = PLACES["face"].start, PLACES["friction"].start
AT, MOVES, TURNS, WIND, TIP_FORCE, NORMAL, ALONG, CONTACT, TIP, RUBS, ROTATION = 0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 29
"""Places of vectors in the result: P, Ṗ, Φ̇, wind, the tip's force, n_D, c and the contact point of the leaf, the tip, its
friction, and R;"""
SINGLE, CHANCES, STATE = 38, 41, 44
"""of angle and speed of the tip and the normal force, of three probabilities, and of the reduced state."""


@kernel
def carry_on(
    arm: ArmParameters, leaf: Array, contact: Array, lever: float, times: Array, rows: Array, memory: Array,
    measured: Array, told: Array, groups: Array, age: float, given: Array, tip: Array, out: Array,
) -> float:  # fmt: skip
    """Fill the result; returns the pitch's cosine.

    Measured rates are read, in places as in `tip`. What is told is `FilterEstimate.told`; `given` and `tip` are scratch.
    """
    n, count = arm.axes.shape[0], groups.shape[1]
    mean, chances, outputs = told, told[2 * SIZE : 2 * SIZE + count], told[2 * SIZE + count :]
    for k in range(3):
        moves, gains = mean[3 + k], outputs[GAIN_OUT + k]
        out[AT + k] = mean[k] + age * moves + 0.5 * age**2 * gains
        out[MOVES + k] = moves + age * gains
        out[WIND + k] = outputs[WIND_OUT + k]
    find_now(times, rows, memory, given[: 3 + n])
    for k in range(3):
        out[STATE + k] = given[k]
    for k in range(n):
        out[STATE + 5 + k] = given[3 + k]
    rate = mean[JOINT_RATE]
    angle = mean[JOINT] + age * rate
    out[STATE + 3], out[STATE + 4] = angle, rate
    roll, pitch, yaw = out[STATE], out[STATE + 1], out[STATE + 2]
    turns = rates_of_euler(out[STATE : STATE + 3], measured[BODY_RATES : BODY_RATES + 3])
    for k in range(3):
        out[TURNS + k] = turns[k]
        given[POSITION + k], given[VELOCITY + k], given[ATTITUDE + k] = out[AT + k], out[MOVES + k], out[STATE + k]
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    rotation = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    for k in range(3):
        for j in range(3):
            out[ROTATION + 3 * k + j] = rotation[k][j]
    # the tip's speed counts without what tilting gives it: body rates of a vehicle that turns about the vertical alone
    given[BODY_RATES], given[BODY_RATES + 1], given[BODY_RATES + 2] = (
        turns[2] * -sp, turns[2] * (cp * sr), turns[2] * (cp * cr),
    )  # fmt: skip
    for k in range(n):
        given[ARM + k], given[ARM + n + k] = out[STATE + 5 + k], measured[ARM + n + k]
    tip_angle, tip_rate = tip_on_leaf(arm, leaf, lever, given, tip)
    out[SINGLE], out[SINGLE + 1] = tip_angle - angle_of_face(leaf, mean[FACE], lever), -lever * tip_rate
    force, along, up = outputs[FORCE_OUT], mean[FRICTION], mean[FRICTION + 1]
    out[SINGLE + 2], out[RUBS], out[RUBS + 1] = force, along, up
    normal, direction, before = leaf_normal(leaf, angle), leaf_direction(leaf, angle), leaf_before(leaf, angle)
    for k in range(3):
        out[NORMAL + k], out[ALONG + k] = normal[k], direction[k]
        out[TIP_FORCE + k] = force * normal[k] + along * direction[k] + up * contact[UP + k]
        out[TIP + k] = out[AT + k] + tip[k]
        out[CONTACT + k] = leaf[HINGE + k] + contact_from_hinge(
            contact[DISTANCE], before, contact[DISTANCE + 1], direction[k], normal[k], contact[UP + k]
        )
    for k in range(3):
        out[CHANCES + k] = 0.0
        for j in range(count):
            out[CHANCES + k] += groups[k, j] * chances[j]
    return cp
