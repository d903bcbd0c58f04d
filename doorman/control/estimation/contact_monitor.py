"""Contact state from the estimated force of the tip, with hysteresis in force and in time.

How noisy the estimate is shows in free flight: a force that noise cannot explain counts at once. A tip that comes to where
the leaf is believed to stand is expected to touch it: little force will do there, once.
"""

from __future__ import annotations

import math

from doorman.scenario import ContactStateSection

_LONGEST_STEP = 0.02
"""Of a longer period, as of a controller that was held up, so much counts as watched [s]."""
_NOISE_AT_FIRST = 0.3
"""Deviation of the force that is assumed before it has been seen [N]."""
_NOISE_TIME = 0.7
"""In which it is learnt [s]."""


class ContactMonitor:
    """Whether the tip presses on the leaf.

    Args:
        settings: Thresholds and times.
    """

    def __init__(self, settings: ContactStateSection) -> None:
        self._settings = settings
        self._for = 0.0
        self._variance = _NOISE_AT_FIRST**2
        self._expected = False
        self.touching = False
        """The contact state."""

    def listen(self, normal_force: float, time_step: float) -> None:
        """Take in one period of free flight: all of the force is noise.

        Args:
            normal_force: Estimated λ_n [N].
            time_step: Since the last call [s].
        """
        self._variance += min(time_step / _NOISE_TIME, 1.0) * (normal_force**2 - self._variance)

    def update(self, normal_force: float, time_step: float, distance: float = math.inf) -> bool:
        """Take in one period.

        Args:
            normal_force: Estimated λ_n [N].
            time_step: Since the last call [s].
            distance: Of the tip from where the leaf is believed to stand; infinite where that is not known [m].

        Returns:
            The contact state.
        """
        settings = self._settings
        if self.touching:
            disagrees, needed = normal_force < settings.lost_below, settings.lost_after
        else:
            noise = math.sqrt(self._variance)
            certain = max(settings.certain_above, settings.certain_deviations * noise)
            if self._expected and distance < settings.arrived_within:
                certain = min(certain, max(settings.arrived_above, settings.arrived_deviations * noise))
            disagrees = normal_force > min(settings.touched_above, certain)
            needed = 0.0 if normal_force > certain else settings.touched_after
        lasted = min(time_step, _LONGEST_STEP)
        self._for = self._for + lasted if disagrees else max(0.0, self._for - lasted)
        if disagrees and self._for >= needed - 1e-9:
            self.declare(not self.touching)
        return self.touching

    def declare(self, touching: bool) -> None:
        """Set the contact state on other evidence.

        Args:
            touching: The new state.
        """
        self.touching, self._for, self._expected = touching, 0.0, False

    def expect(self) -> None:
        """Expect a touch where the leaf is believed to stand; what follows must bear that it comes a little later."""
        self.declare(False)
        self._expected = True
