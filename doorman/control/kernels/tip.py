r"""Kernel of the tip: angle and rate of a leaf that it is on; the fast twin of `Coupling.door_state`."""

from __future__ import annotations

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.kinematics.doors.leaf.leaf_kernels import angle_of_point, leaf_normal
from doorman.kinematics.vehicles.arms.arm import ArmParameters, tip_motion

POSITION, VELOCITY, ATTITUDE, BODY_RATES, ARM = 0, 3, 6, 9, 12
"""Places in what is given; of the arm there are angles, then rates."""


@kernel
def tip_on_leaf(arm: ArmParameters, leaf: Array, lever: float, given: Array, tip: Array) -> tuple[float, float]:
    """Angle and rate of a leaf that the tip is on: two numbers [rad], [rad/s]."""
    n = arm.axes.shape[0]
    angles, rates = given[ARM : ARM + n], given[ARM + n : ARM + 2 * n]
    tip_motion(arm, given[ATTITUDE : ATTITUDE + 3], given[BODY_RATES : BODY_RATES + 3], angles, rates, tip)
    angle = angle_of_point(leaf, given[0] + tip[0], given[1] + tip[1], given[2] + tip[2])
    x, y, z = leaf_normal(leaf, angle)
    speed = x * (given[VELOCITY] + tip[3]) + y * (given[VELOCITY + 1] + tip[4]) + z * (given[VELOCITY + 2] + tip[5])
    return angle, -speed / lever
