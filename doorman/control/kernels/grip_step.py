"""Kernels of a gripping tip: the rate of the leaf that it holds, and the push at it."""

from __future__ import annotations

import math

from doorman.compilation import kernel
from doorman.control.kernels.estimator_memory import BEYOND, LEVER, MASS, VEHICLE_RATE, WIND, EstimatorMemory
from doorman.control.kernels.tip import POSITION as MEASURED
from doorman.control.kernels.tip import VELOCITY as MEASURED_VELOCITY
from doorman.control.kernels.vehicle_step import FORCE, LATE, OUTER_FORCE, SEEN, VELOCITY, advance_vehicle
from doorman.kinematics.doors.leaf.leaf_kernels import TURN, leaf_direction, leaf_normal

GRIP_POLES = 2.0
"""Poles of a gripping tip's observer in those of the vehicle's: no force is known that moves it, so that a light leaf which gains
speed would leave a slow observer behind."""


@kernel
def along_normal(e: EstimatorMemory, normal: tuple[float, float, float]) -> float:
    """Share of rotors, gravity and wind along a direction [N]."""
    total = 0.0
    for k in range(3):
        total += normal[k] * (e.acting[FORCE + k] + e.memory[WIND + k])
    return total


@kernel
def rate_of_a_grip(e: EstimatorMemory, tip_angle: float, pose_time: float, now: float, time_step: float) -> float:
    """Rate of a leaf that the tip grips, by an observer of the tip's own place [rad/s].

    The vehicle's velocity lags behind what nobody knows of; body rates do not. A vehicle that turns about the tip it holds is
    moved by the grip, so the sum of the two has the tip, which hardly moves, swing with the vehicle.
    """
    if math.isnan(e.grip[SEEN]):
        e.grip[LATE] = e.vehicle[LATE]
        for k in range(3):
            e.grip[VELOCITY + k], e.grip[OUTER_FORCE + k] = e.seen[MEASURED_VELOCITY + k] + e.tip[3 + k], 0.0
    for k in range(3):
        e.gripped[k] = e.seen[MEASURED + k] + e.tip[k]
    advance_vehicle(e.grip, e.gripped, 1.0, GRIP_POLES * e.numbers[VEHICLE_RATE], pose_time, now, time_step)
    speed, normal = 0.0, leaf_normal(e.door.leaf, tip_angle)
    for k in range(3):
        speed += normal[k] * e.grip[VELOCITY + k]
    return float(-speed / e.numbers[LEVER])


@kernel
def push_of_a_grip(e: EstimatorMemory, tip_angle: float, tip_rate: float, time_step: float) -> float:
    r"""Push at the tip that would turn leaf and vehicle together as they turn now [N].

    A vehicle that turns about the tip it holds moves otherwise than the tip. With :math:`u = n_D^T v + D_V\dot\alpha`, its
    speed along the normal beyond the tip's, the push is :math:`n_D^T F - m_A\dot u + m_A\dot\alpha\,n_D'^T v`; the
    normal of a hinged leaf bends by :math:`n_D' = c` (docs/theory.md).
    """
    normal, bend = leaf_normal(e.door.leaf, tip_angle), leaf_direction(e.door.leaf, tip_angle)
    beyond = bends = 0.0
    for k in range(3):
        beyond += normal[k] * e.vehicle[VELOCITY + k]
        bends += bend[k] * e.vehicle[VELOCITY + k]
    bends *= e.door.leaf[TURN]
    beyond += e.numbers[LEVER] * tip_rate
    change = 0.0 if math.isnan(e.memory[BEYOND]) else beyond - e.memory[BEYOND]
    e.memory[BEYOND] = beyond
    taken = e.numbers[MASS] * (change / time_step - tip_rate * bends) if time_step > 0.0 else 0.0
    return along_normal(e, normal) - taken
