"""Kernel of `VehicleObserver`: one period of it; its docstring has the equations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]

POSITION, VELOCITY, OUTER_FORCE, CENTER, SEEN, LATE, SIZE = 0, 3, 6, 9, 15, 16, 17
"""Places in the memory: three vectors, place and velocity of the centre of mass, time of the last position (NaN before the
first), and the age of positions that ω is chosen for."""
MEASURED, FORCE, PLACE, SPEED, GIVEN = 0, 3, 6, 9, 12
"""Places in what is given: p of O_B, F that acted since the last call, place and velocity of the centre of mass from O_B."""

LATEST = 0.6
"""Largest ω t; for older positions ω is less."""
_FORGETS = 0.2
"""By so much a second the age that ω is chosen for falls, where positions are new again [s/s]."""


@kernel
def advance_vehicle(
    memory: Array, given: Array, mass: float, fastest: float, measured_at: float, now: float, time_step: float
) -> None:
    """One period of the observer."""
    if math.isnan(memory[SEEN]):  # the centre of mass moves as it is believed to
        for k in range(3):
            memory[POSITION + k] = given[MEASURED + k]
            memory[VELOCITY + k] -= given[SPEED + k]
            memory[CENTER + k], memory[CENTER + 3 + k] = given[PLACE + k], given[SPEED + k]
        memory[SEEN] = measured_at
        return
    of_place, of_speed, of_force, age = 0.0, 0.0, 0.0, now - measured_at
    if measured_at > memory[SEEN]:
        apart = measured_at - memory[SEEN]
        memory[SEEN] = measured_at
        memory[LATE] = max(age, memory[LATE] - _FORGETS * apart)
        rate = min(fastest, LATEST / memory[LATE]) if memory[LATE] > 0.0 else fastest
        kept = math.exp(-rate * apart)
        lost = 1.0 - kept
        of_place, of_speed = 1.0 - kept**3, 1.5 * (1.0 - kept**2) * lost / apart
        of_force = mass * lost**3 / apart**2
    for k in range(3):
        place, speed = given[PLACE + k], given[SPEED + k]
        acceleration = (given[FORCE + k] + memory[OUTER_FORCE + k]) / mass
        v = memory[VELOCITY + k] + memory[CENTER + 3 + k]
        p = memory[POSITION + k] + memory[CENTER + k] + time_step * (v + 0.5 * time_step * acceleration)
        v += time_step * acceleration
        off = given[MEASURED + k] + place - (p - age * v)
        memory[OUTER_FORCE + k] += of_force * off
        memory[POSITION + k] = p + of_place * off - place
        memory[VELOCITY + k] = v + of_speed * off - speed
        memory[CENTER + k], memory[CENTER + 3 + k] = place, speed
