"""The doorway: where between the jambs a vehicle may be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.model import Model

Array = NDArray[np.float64]

_SENT_BACK = 1.5
"""Share of the way that a vehicle is nearer to a jamb than it may be, by which its place is moved away."""
_AHEAD = 0.3
"""For a vehicle that drifts on for so long [s]."""


class Doorway:
    """Places of the vehicle between the jambs.

    Args:
        model: Model of the scenario.
        margin: From the jambs, the planner's if not given [m].
    """

    def __init__(self, model: Model, margin: float | None = None) -> None:
        room = model.vehicle.radius + (model.scenario.planner.margin if margin is None else margin)
        hinge = float(model.door.hinge_position[1])
        self.lowest, self.highest = hinge + room, hinge + model.door.width - room
        """Bounds of y that keep the margin [m]."""

    def inside(self, place: Array, planned: Array, position: Array, velocity: Array) -> Array:
        """A place no nearer to a jamb than the plan is, or may be.

        A vehicle that is nearer, or will be soon, is sent back beyond.

        Args:
            place: Where the vehicle is to be sent, shape (3,), world frame [m].
            planned: Where the plan has it, shape (3,), world frame [m].
            position: Where it is, shape (3,), world frame [m].
            velocity: Its velocity, shape (3,), world frame [m/s].

        Returns:
            Shape (3,), world frame [m].
        """
        lowest, highest = min(self.lowest, planned[1]), max(self.highest, planned[1])
        allowed = place.copy()
        soon = position[1] + _AHEAD * velocity[1]
        allowed[1] = min(max(place[1], lowest), highest) + _SENT_BACK * (min(max(soon, lowest), highest) - soon)
        return allowed
