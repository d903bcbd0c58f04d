"""What a tip bears that holds on to a handle from one step of a task to the next: a lever that is turned wants to turn back."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.model import Model
from doorman.stages import Handover

_AVERAGED = 0.5
"""Over which the force is averaged: its estimate is as noisy as the poses [s]."""


class HeldLoad:
    """Force of the tip while it is tied to the leaf; `after` is what the step before has left."""

    def __init__(self, model: Model, after: Handover | None) -> None:
        self._model, self._bears, self._held = model, after is not None, False
        self.force: Array = np.zeros(3) if after is None else after.tip_force
        """Average, shape (3,), world frame [N]."""

    @property
    def in_face(self) -> Array:
        """Its shares along leaf and hinge at the start, shape (2,) [N]."""
        door = self._model.door
        return np.array([door.leaf_direction(self._model.start_angle) @ self.force, door.up @ self.force])

    def note(self, estimate: Estimate, tied: bool, elapsed: float) -> bool:
        """Average on while the tip is tied; returns whether it has just let go, and nothing bears on it any more."""
        held, self._held = self._held, tied
        if tied:
            self.force = self.force + min(elapsed / _AVERAGED, 1.0) * (estimate.tip_force - self.force)
        return self._bears and held and not tied

    def outer(self, estimate: Estimate) -> Array:
        """What acts on the vehicle beside rotors and push, shape (3,) [N]: the wind, and a lever that is held down."""
        if not (self._bears and self._held):
            return estimate.wind
        normal = estimate.normal
        return np.asarray(estimate.wind - (self.force - (normal @ self.force) * normal))
