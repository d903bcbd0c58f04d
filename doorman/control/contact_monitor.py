"""Contact state from the estimated force of the tip, with hysteresis in force and in time."""

from __future__ import annotations

from doorman.scenario import ContactStateSection


class ContactMonitor:
    """Whether the tip presses on the leaf.

    Args:
        settings: Thresholds and times.
    """

    def __init__(self, settings: ContactStateSection) -> None:
        self._settings = settings
        self._for = 0.0
        self.touching = False
        """The contact state."""

    def update(self, normal_force: float, time_step: float) -> bool:
        """Take in one period.

        Args:
            normal_force: Estimated λ_n [N].
            time_step: Since the last call [s].

        Returns:
            The contact state.
        """
        settings = self._settings
        if self.touching:
            disagrees, needed = normal_force < settings.lost_below, settings.lost_after
        else:
            disagrees, needed = normal_force > settings.touched_above, settings.touched_after
        self._for = self._for + time_step if disagrees else max(0.0, self._for - time_step)
        if self._for >= needed - 1e-9:
            self.declare(not self.touching)
        return self.touching

    def declare(self, touching: bool) -> None:
        """Set the state on other evidence."""
        self.touching, self._for = touching, 0.0
