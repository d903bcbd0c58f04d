"""Places of a scenario that everybody who flies it must agree on: where the vehicle takes off, hovers and touches."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array, frozen
from doorman.model import Model

LEG_CLEARANCE = 0.10
"""Clearance of the arm in its start posture above the ground while the vehicle stands [m]."""


LYING = math.radians(20.0)
"""No vehicle stands so tilted on its legs [rad]."""


@dataclass(frozen=True)
class Places:
    """Positions of O_B, world frame, and the heading."""

    touch: Array
    """Where the tip touches the leaf in the start posture, shape (3,) [m]."""
    hover: Array
    """`mission.hover_distance` away from there, outward along the leaf's normal, or before the doorway, shape (3,) [m]."""
    pad: Array
    """Where the vehicle stands below `hover` before take-off, shape (3,) [m]."""
    yaw: float
    """[rad]."""

    @classmethod
    def of(cls, model: Model) -> Places:
        """Places of a scenario.

        Args:
            model: Model of the scenario.
        """
        state = model.start_state
        touch = model.coupling.vehicle_motion(state, np.zeros(3), np.zeros(model.n_arm)).position
        hover = touch + model.hover_offset
        lowest = min(float(point[2]) for point in model.vehicle.point_positions(model.start_arm))
        pad = np.array([hover[0], hover[1], LEG_CLEARANCE - min(lowest, 0.0)])
        return cls(frozen(touch), frozen(hover), frozen(pad), float(state[2]))
