r"""Kernel of the vehicle on the leaf: the fast twin of `Coupling.vehicle_motion`."""

from __future__ import annotations

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.kinematics.doors.leaf.leaf_kernels import (
    HINGE,
    OFFSET,
    SLIDE,
    TURN,
    contact_from_hinge,
    leaf_before,
    leaf_direction,
    leaf_normal,
    lever,
)
from doorman.kinematics.vehicles.arms.arm import ArmParameters, tip_motion

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
    before = leaf_before(leaf, angle)
    for k in range(3):
        place = contact_from_hinge(distance, before, height, direction[k], normal[k], contact[UP + k])
        moves = lever(leaf[TURN], leaf[SLIDE], distance, leaf[OFFSET], direction[k], normal[k])
        out[k] = leaf[HINGE + k] + place - out[k]
        out[3 + k] = rate * moves - out[3 + k]
