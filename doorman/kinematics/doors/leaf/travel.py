"""Way of a door, or of any mechanism, from where a task begins to where it ends."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Travel:
    """Direction of a task: what is before the goal, whichever way that is."""

    start: float
    """α at the start [rad]."""
    goal: float
    """α at the goal [rad]."""

    @property
    def sense(self) -> float:
        """1 where α grows on the way, else −1."""
        return math.copysign(1.0, self.goal - self.start)

    @property
    def length(self) -> float:
        """Length of the way [rad]."""
        return abs(self.goal - self.start)

    def left(self, angle: float) -> float:
        """How far the goal is ahead of α, negative beyond it [rad]."""
        return self.sense * (self.goal - angle)

    def done(self, angle: float) -> float:
        """How far α is ahead of the start [rad]."""
        return self.sense * (angle - self.start)

    def share(self, angle: float) -> float:
        """Share of the way that is done, in [0, 1]; 1 where there is no way to go."""
        return min(max(self.done(angle) / self.length, 0.0), 1.0) if self.length > 0.0 else 1.0

    def ahead(self, rate: float) -> float:
        """A rate or torque, positive towards the goal, in the given unit.

        Used for a rate of α, for a torque that turns the leaf, and for one that resists.
        """
        return self.sense * rate
