"""A leaf that turns on a hinge."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.doors.leaf.leaf_motion import LeafMotion

Array = NDArray[np.float64]


class Turning(LeafMotion):
    """On a hinge."""

    per_angle = 1.0

    def leaf(self, door_angle: float) -> tuple[float, float]:
        """Direction c: cos α along i, sin α along a. See `LeafMotion`."""
        return math.cos(door_angle), math.sin(door_angle)

    def normal(self, door_angle: float) -> tuple[float, float]:
        """Normal n: sin α along i, −cos α along a. See `LeafMotion`."""
        return math.sin(door_angle), -math.cos(door_angle)

    def normals(self, door_angles: Array) -> Array:
        """Normals at many angles. See `LeafMotion`."""
        return np.column_stack([np.sin(door_angles), -np.cos(door_angles)])

    def bend(self, door_angle: float) -> tuple[float, float]:
        """Change of the normal, which is c. See `LeafMotion`."""
        return self.leaf(door_angle)

    def way(self, door_angle: float) -> float:
        """Zero: a hinge does not move along i. See `LeafMotion`."""
        return 0.0

    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        r"""Lever :math:`J = -D_V n - o\,c`. See `LeafMotion`."""
        (n_into, n_along), (c_into, c_along) = self.normal(door_angle), self.leaf(door_angle)
        return -(distance * n_into + offset * c_into), -(distance * n_along + offset * c_along)

    def lever_length(self, distance: float) -> float:
        """D_V itself [m]. See `LeafMotion`."""
        return distance

    def wind_lever(self, width: float) -> float:
        """Half the width: a wind presses on the middle of the leaf [m]. See `LeafMotion`."""
        return 0.5 * width

    def angle_of_face(self, before: float, distance: float) -> float:
        """Angle arcsin(before/D_V) [rad]. See `LeafMotion`."""
        return math.asin(before / distance)

    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        r"""Angle :math:`\mathrm{atan2}(a^T r,\ i^T r) - \arcsin(o/|r|)` of a point at r from P_h [rad]. See `LeafMotion`."""
        way = math.hypot(along, into)
        before = math.asin(min(max(offset / way, -1.0), 1.0)) if way > 0.0 else 0.0
        return middle + math.remainder(math.atan2(along, into) - before - middle, 2.0 * math.pi)

    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        """Torque :math:`w_n c_z - w_c n_z` [N m]. See `LeafMotion`."""
        return float(weight[1] * leaf_up - weight[0] * normal_up)
