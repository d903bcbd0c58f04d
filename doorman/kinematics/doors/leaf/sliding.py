"""A leaf that slides."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.doors.leaf.leaf_motion import SLIDE_RADIUS, LeafMotion

Array = NDArray[np.float64]


class Sliding(LeafMotion):
    """Along i."""

    per_angle = SLIDE_RADIUS

    def leaf(self, door_angle: float) -> tuple[float, float]:
        """Direction a, at any α. See `LeafMotion`."""
        return 0.0, 1.0

    def normal(self, door_angle: float) -> tuple[float, float]:
        """Normal i, at any α. See `LeafMotion`."""
        return 1.0, 0.0

    def normals(self, door_angles: Array) -> Array:
        """Normals at many angles, all i. See `LeafMotion`."""
        return np.tile(self.normal(0.0), (len(door_angles), 1))

    def bend(self, door_angle: float) -> tuple[float, float]:
        """Zero: a slide keeps its normal. See `LeafMotion`."""
        return 0.0, 0.0

    def way(self, door_angle: float) -> float:
        """Way r (α − π/2) [m]. See `LeafMotion`."""
        return self.per_angle * (door_angle - 0.5 * math.pi)

    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        """Lever J = −r i. See `LeafMotion`."""
        return -self.per_angle, 0.0

    def lever_length(self, distance: float) -> float:
        """The radius r [m]. See `LeafMotion`."""
        return self.per_angle

    def wind_lever(self, width: float) -> float:
        """The radius r [m]. See `LeafMotion`."""
        return self.per_angle

    def angle_of_face(self, before: float, distance: float) -> float:
        """Angle before/r [rad]. See `LeafMotion`."""
        return before / self.per_angle

    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        """Angle π/2 − (into + o)/r [rad]. See `LeafMotion`."""
        return 0.5 * math.pi - (into + offset) / self.per_angle

    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        r"""Torque :math:`-r\,m g\,n_z` [N m]. See `LeafMotion`."""
        return float(-weight[0] * normal_up)
