"""Kernels of `ContactMonitor`: one period of it; its docstring has the rule."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]

(
    TOUCHED_ABOVE, TOUCHED_AFTER, CERTAIN_ABOVE, CERTAIN_DEVIATIONS, ARRIVED_WITHIN, ARRIVED_ABOVE, ARRIVED_DEVIATIONS,
    LOST_BELOW, LOST_AFTER, NUMBERS,
) = range(10)  # fmt: skip
"""Places in the numbers: the fields of `ContactThresholds`."""
TOUCHING, LASTED, VARIANCE, EXPECTED, MEMORY = range(5)
"""Places in the memory: the contact state, for how long the force has disagreed, variance of its noise, and whether a touch is
expected."""

NOISE_AT_FIRST = 0.3
"""Deviation of the force that is assumed before it has been seen [N]."""
_LONGEST_STEP = 0.02
"""Of a longer period, as of a controller that was held up, so much counts as watched [s]."""
_NOISE_TIME = 0.7
"""In which the noise is learnt [s]."""


@kernel
def listen_to_noise(memory: Array, normal_force: float, time_step: float) -> None:
    """Take in one period of free flight."""
    memory[VARIANCE] += min(time_step / _NOISE_TIME, 1.0) * (normal_force**2 - memory[VARIANCE])


@kernel
def watch_contact(numbers: Array, memory: Array, normal_force: float, time_step: float, distance: float) -> bool:
    """Take in one period, and return the contact state."""
    if memory[TOUCHING] != 0.0:
        disagrees, needed = normal_force < numbers[LOST_BELOW], numbers[LOST_AFTER]
    else:
        noise = math.sqrt(memory[VARIANCE])
        certain = max(numbers[CERTAIN_ABOVE], numbers[CERTAIN_DEVIATIONS] * noise)
        if memory[EXPECTED] != 0.0 and distance < numbers[ARRIVED_WITHIN]:
            certain = min(certain, max(numbers[ARRIVED_ABOVE], numbers[ARRIVED_DEVIATIONS] * noise))
        disagrees = normal_force > min(numbers[TOUCHED_ABOVE], certain)
        needed = 0.0 if normal_force > certain else numbers[TOUCHED_AFTER]
    lasted = min(time_step, _LONGEST_STEP)
    memory[LASTED] = memory[LASTED] + lasted if disagrees else max(0.0, memory[LASTED] - lasted)
    if disagrees and memory[LASTED] >= needed - 1e-9:
        declare_contact(memory, memory[TOUCHING] == 0.0)
    return bool(memory[TOUCHING] != 0.0)


@kernel
def declare_contact(memory: Array, touching: bool) -> None:
    """Set the state on other evidence."""
    memory[TOUCHING], memory[LASTED], memory[EXPECTED] = (1.0 if touching else 0.0), 0.0, 0.0
