"""Whether a door is slammed: the leaf throws the tip back."""

from __future__ import annotations

import math

from doorman.control.estimation.estimator import Estimate
from doorman.gravity import weight_of

_THROWN_BACK = 0.4
"""A tip on the leaf that is faster, backwards, is thrown back by a slammed door [m/s],"""
_SURELY = 0.008
"""if it is so for longer than this [s]."""
_STRUCK, _ALONG = 0.068, 0.8
"""So is one that has left the leaf, if that strikes it: by more than this share of the weight, and so much of it along its
normal;"""
_SOON = 0.1
"""its speed is what it will be in so long [s], as the estimate lags."""


class SlamDetector:
    """Feels whether the leaf throws the tip back.

    A vehicle that is blown or taken away from the leaf moves back as fast: the tip must feel it. As it lets go and goes out,
    nothing else strikes it as hard along the leaf's normal.

    Args:
        mass: m [kg].
    """

    def __init__(self, mass: float) -> None:
        self._mass = mass
        self._thrown_for = 0.0

    def reset(self) -> None:
        """Forget what was felt: nothing can throw the tip back now, or that is given way to already."""
        self._thrown_for = 0.0

    def update(self, estimate: Estimate, gripping: bool, leaving: bool, retreating: float, time_step: float) -> bool:
        """Take in what is known now."""
        speed, struck = estimate.tip_speed, gripping or estimate.touching
        if leaving:
            force = max(estimate.normal_force, 0.0)
            struck = struck or force > max(
                _STRUCK * weight_of(self._mass), _ALONG * math.sqrt(estimate.tip_force.dot(estimate.tip_force))
            )
            speed -= _SOON * force / self._mass
        if not struck or speed >= -(_THROWN_BACK + retreating):
            self.reset()
            return False
        self._thrown_for += time_step
        return self._thrown_for > _SURELY
