r"""Kernel of the vehicle on the leaf: the fast twin of `Coupling.motion_of`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.leaf import HINGE, OFFSET, PER_ANGLE, SLIDES, leaf_direction, leaf_normal
from doorman.kinematics.vehicles.arms.arm import ArmParameters, tip_motion

Array = NDArray[np.float64]

UP, DISTANCE, PLACE = 0, 3, 5
"""Places in where the contact is: u of the door, D_V and D_H, and the size."""


@kernel
def vehicle_on_leaf(
    arm: ArmParameters, leaf: Array, contact: Array, state: Array, body_rates: Array, arm_rates: Array, out: Array
) -> None:
    r"""Place :math:`P = P_h + D_V c - o\,n_D + D_H u - R\,d` and velocity :math:`\dot\alpha J - R(\Omega\times d) - R\dot d`."""
    tip_motion(arm, state[:3], body_rates, state[5:], arm_rates, out)
    angle, rate, distance, height = state[3], state[4], contact[DISTANCE], contact[DISTANCE + 1]
    normal, direction = leaf_normal(leaf, angle), leaf_direction(leaf, angle)
    slides = leaf[SLIDES] != 0.0
    before = leaf[OFFSET]
    if slides:
        before += leaf[PER_ANGLE] * (angle - 0.5 * np.pi)
    for k in range(3):
        lever = -(distance * normal[k] + leaf[OFFSET] * direction[k])
        if slides:
            lever = -leaf[PER_ANGLE] * normal[k]
        beside = distance * direction[k] - before * normal[k]
        out[k] = leaf[HINGE + k] + beside + height * contact[UP + k] - out[k]
        out[3 + k] = rate * lever - out[3 + k]
