"""Tells a collision by forces, tilt and height: a vehicle in the air that something else than its rotors bears lies on it."""

from __future__ import annotations

import math

from doorman.hardware.safety import Observation

_BORNE = 0.3
"""Share of the weight that something else bears: the friction of a tip that presses lifts less [1]."""
_FOR = 0.3
"""For so long: a blow at the first touch passes sooner [s]."""


class CarriedWatch:
    """Lift by the surroundings of a vehicle whose gripper holds nothing."""

    def __init__(self) -> None:
        self._since = math.inf
        self.words = ""  # what bore how much of the vehicle, where it lay and how; empty if nothing did

    def note(self, seen: Observation, holds: bool) -> None:
        """Take in a look, and whether the gripper holds the leaf, which may bear the vehicle."""
        if holds or not seen.lift > _BORNE:
            self._since = math.inf
            return
        self._since = min(self._since, seen.now)
        if seen.now - self._since > _FOR and not self.words:
            x, y, z = seen.position.tolist()
            self.words = (
                f"something bore {seen.lift:.0%} of the vehicle's weight at {x:.2f}, {y:.2f}, {z:.2f} m, "
                f"tilted by {math.degrees(seen.tilt):.0f}°: it lay on sill, frame or floor"
            )
