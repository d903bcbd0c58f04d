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
        """Direction a, at any α. See `LeafMotion`.

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a.
        """
        return 0.0, 1.0

    def normal(self, door_angle: float) -> tuple[float, float]:
        """Normal i, at any α. See `LeafMotion`.

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a.
        """
        return 1.0, 0.0

    def normals(self, door_angles: Array) -> Array:
        """Normals at many angles, all i. See `LeafMotion`.

        Args:
            door_angles: α, shape (m,) [rad].

        Returns:
            Components along i and a, shape (m, 2).
        """
        return np.tile(self.normal(0.0), (len(door_angles), 1))

    def bend(self, door_angle: float) -> tuple[float, float]:
        """Zero: a slide keeps its normal. See `LeafMotion`.

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a [1/rad].
        """
        return 0.0, 0.0

    def way(self, door_angle: float) -> float:
        """Way r (α − π/2) [m]. See `LeafMotion`.

        Args:
            door_angle: α [rad].
        """
        return self.per_angle * (door_angle - 0.5 * math.pi)

    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        """Lever J = −r i. See `LeafMotion`.

        Args:
            door_angle: α [rad].
            distance: D_V [m].
            offset: o [m].

        Returns:
            Components along i and a [m].
        """
        return -self.per_angle, 0.0

    def lever_length(self, distance: float) -> float:
        """The radius r [m]. See `LeafMotion`.

        Args:
            distance: D_V [m].
        """
        return self.per_angle

    def wind_lever(self, width: float) -> float:
        """The radius r [m]. See `LeafMotion`.

        Args:
            width: Of the leaf, from its hinge [m].
        """
        return self.per_angle

    def angle_of_face(self, before: float, distance: float) -> float:
        """Angle before/r [rad]. See `LeafMotion`.

        Args:
            before: So far [m].
            distance: D_V [m].
        """
        return before / self.per_angle

    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        """Angle π/2 − (into + o)/r [rad]. See `LeafMotion`.

        Args:
            into: Along i from P_h [m].
            along: Along a from P_h [m].
            offset: o [m].
            middle: Of the range of α, in which it is looked for [rad].
        """
        return 0.5 * math.pi - (into + offset) / self.per_angle

    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        r"""Torque :math:`-r\,m g\,n_z` [N m]. See `LeafMotion`.

        Args:
            weight: m g times the place of the centre of mass along c and n, shape (2,) [N m]; of a slide m g r at first.
            leaf_up: c_z.
            normal_up: n_z.
        """
        return float(-weight[0] * normal_up)
