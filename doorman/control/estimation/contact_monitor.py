"""Contact state from the estimated force of the tip, with hysteresis in force and in time.

How noisy the estimate is shows in free flight: a force that noise cannot explain counts at once. A tip that comes to where
the leaf is believed to stand is expected to touch it: little force will do there, once.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.beliefs import ContactThresholds
from doorman.control.kernels.contact_step import (
    EXPECTED,
    LASTED,
    MEMORY,
    NOISE_AT_FIRST,
    TOUCHING,
    VARIANCE,
    listen_to_noise,
    watch_contact,
)

Array = NDArray[np.float64]


class ContactMonitor:
    """Whether the tip presses on the leaf.

    Args:
        settings: Thresholds and times.
    """

    def __init__(self, settings: ContactThresholds) -> None:
        self.numbers = np.array([
            settings.touched_above, settings.touched_after, settings.certain_above, settings.certain_deviations,
            settings.arrived_within, settings.arrived_above, settings.arrived_deviations, settings.lost_below,
            settings.lost_after,
        ])  # fmt: skip
        """What the kernels of `contact_step` read, shape (NUMBERS,)."""
        self.memory = np.zeros(MEMORY)
        """What they write to, shape (MEMORY,)."""
        self.memory[VARIANCE] = NOISE_AT_FIRST**2

    @property
    def touching(self) -> bool:
        """The contact state."""
        return bool(self.memory[TOUCHING])

    def listen(self, normal_force: float, time_step: float) -> None:
        """Take in one period of free flight: all of the force is noise."""
        listen_to_noise(self.memory, normal_force, time_step)

    def update(self, normal_force: float, time_step: float, distance: float = math.inf) -> bool:
        """Take in one period."""
        return watch_contact(self.numbers, self.memory, normal_force, time_step, distance)

    def declare(self, touching: bool) -> None:
        """Set the contact state on other evidence."""
        self.memory[TOUCHING], self.memory[LASTED], self.memory[EXPECTED] = touching, 0.0, 0.0

    def expect(self) -> None:
        """Expect a touch where the leaf is believed to stand; what follows must bear that it comes a little later."""
        self.declare(False)
        self.memory[EXPECTED] = 1.0
