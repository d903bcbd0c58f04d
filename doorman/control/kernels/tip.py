r"""Kernel of the tip: angle and rate of a leaf that it is on; the fast twin of `Coupling.door_state`."""

from __future__ import annotations

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.kinematics.doors.leaf.leaf_kernels import LeafNumbers, angle_of_point, leaf_normal
from doorman.kinematics.vehicles.arms.arm import ArmParameters, tip_motion
from doorman.numba_types.records import Record, Vector3


class TipMotion(Record):
    """The tip relative to O_B, in world axes."""

    position: Vector3  # [m]
    velocity: Vector3  # [m/s]


@kernel
def tip_on_leaf(
    arm: ArmParameters, leaf: LeafNumbers, lever: float, position: Array, velocity: Array, attitude: Array,
    body_rates: Array, arm_angles: Array, arm_rates: Array, tip: TipMotion,
) -> tuple[float, float]:  # fmt: skip
    """Angle and rate of a leaf that the tip is on: two numbers [rad], [rad/s]; the tip's motion stays in `tip`."""
    at, moves = tip.position, tip.velocity
    tip_motion(arm, attitude, body_rates, arm_angles, arm_rates, at, moves)
    angle = angle_of_point(leaf, position[0] + at[0], position[1] + at[1], position[2] + at[2])
    x, y, z = leaf_normal(leaf, angle)
    speed = x * (velocity[0] + moves[0]) + y * (velocity[1] + moves[1]) + z * (velocity[2] + moves[2])
    return angle, -speed / lever
