"""Kernel of `DoorObserver`: one period of it; its docstring has the equations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_weight

Array = NDArray[np.float64]

TORQUE, RATE, ESTIMATE, MEMORY = range(4)
"""Places in the memory: the filtered torque, the filtered rate, NaN before the first, and τ̂_d."""
BANDWIDTH, LIMIT, DAMPING, STIFFNESS, LEVER, VEHICLE_INERTIA, REST, NUMBERS = range(8)
"""Places in the numbers: [rad/s], bound of the estimate, b, k, D_V, m_A D_V² and α_0."""


@kernel
def observe_hinge(
    numbers: Array,
    leaf: Array,
    memory: Array,
    door_angle: float,
    door_rate: float,
    push: float,
    inertia: float,
    time_step: float,
) -> float:
    """One period of the observer: τ̂_d [N m]."""
    if numbers[BANDWIDTH] == 0.0:
        return float(memory[ESTIMATE])
    if math.isnan(memory[RATE]):
        memory[RATE], memory[TORQUE] = door_rate, memory[ESTIMATE]
    resistance = numbers[DAMPING] * door_rate + numbers[STIFFNESS] * (door_angle - numbers[REST])
    resistance += leaf_weight(leaf, door_angle)
    part = 1.0 - math.exp(-numbers[BANDWIDTH] * time_step)
    memory[TORQUE] += part * (-numbers[LEVER] * push - resistance - memory[TORQUE])
    memory[RATE] += part * (door_rate - memory[RATE])
    taken = (inertia + numbers[VEHICLE_INERTIA]) * numbers[BANDWIDTH] * (door_rate - memory[RATE])
    memory[ESTIMATE] = min(max(memory[TORQUE] - taken, -numbers[LIMIT]), numbers[LIMIT])
    memory[TORQUE] = memory[ESTIMATE] + taken  # anti-windup: the state stays where the bound is
    return float(memory[ESTIMATE])


@kernel
def restart_hinge(numbers: Array, memory: Array, estimate: float) -> None:
    """Go on from another estimate [N m]."""
    memory[ESTIMATE] = min(max(estimate, -numbers[LIMIT]), numbers[LIMIT])
    memory[RATE] = math.nan
