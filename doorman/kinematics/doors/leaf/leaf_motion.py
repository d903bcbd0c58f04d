r"""How a leaf moves with its door's angle α: turning on a hinge, or sliding.

In the doorway, with the unit vectors i (through the closed leaf), a (along it) and u (up along the hinge):

============================ ======================================= =============================
symbol                       turning                                 sliding
============================ ======================================= =============================
direction of the leaf c(α)   :math:`\cos\alpha\,i + \sin\alpha\,a`   :math:`a`
normal n(α)                  :math:`\sin\alpha\,i - \cos\alpha\,a`   :math:`i`
way of the leaf              none                                    :math:`-r(\alpha-\pi/2)\,i`
lever J                      :math:`-D_V n - o\,c`                   :math:`-r\,i`
weight's torque G(α)         :math:`w_n c_z - w_c n_z`               :math:`-r\,m g\,n_z`
============================ ======================================= =============================

α of a slide is its way over a radius r, as of a wheel that rolls along it: a radian is the way of a tip at a handle, so that
whatever is said of swings in radians holds for slides. G is in the sense of damping.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLIDE_RADIUS = 0.4
"""r: the lever of a small door's handle. 1.5° of α are 1 cm [m]."""


class LeafMotion(ABC):
    """Components are those along i and a."""

    per_angle: float
    """Change of the joint's value for one of α [1, or m]."""

    @abstractmethod
    def leaf(self, door_angle: float) -> tuple[float, float]:
        """Direction of the leaf, c(α).

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a.
        """

    @abstractmethod
    def normal(self, door_angle: float) -> tuple[float, float]:
        """Normal of the leaf, n(α).

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a.
        """

    @abstractmethod
    def bend(self, door_angle: float) -> tuple[float, float]:
        """Change of the normal with α, dn/dα.

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a [1/rad].
        """

    @abstractmethod
    def way(self, door_angle: float) -> float:
        """How far the leaf has moved against i, from closed [m].

        Args:
            door_angle: α [rad].
        """

    @abstractmethod
    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        """Components of J.

        Args:
            door_angle: α [rad].
            distance: D_V [m].
            offset: o [m].
        """

    @abstractmethod
    def lever_length(self, distance: float) -> float:
        """Speed of the contact point along the normal for a unit rate of α [m].

        Args:
            distance: D_V [m].
        """

    @abstractmethod
    def wind_lever(self, width: float) -> float:
        """Torque in the joint for each newton that a wind presses on the face with [m].

        Args:
            width: Of the leaf, from its hinge [m].
        """

    @abstractmethod
    def angle_of_face(self, before: float, distance: float) -> float:
        """By how much α of a point is less if the face stands before its place [rad].

        Args:
            before: So far [m].
            distance: D_V [m].
        """

    @abstractmethod
    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        """α at which a point is on the face [rad].

        Args:
            into: Along i from P_h [m].
            along: Along a from P_h [m].
            offset: o [m].
            middle: Of the range of α, in which it is looked for [rad].
        """

    @abstractmethod
    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        """G [N m].

        Args:
            weight: m g times the place of the centre of mass along c and n, shape (2,) [N m]; of a slide m g r at first.
            leaf_up: c_z.
            normal_up: n_z.
        """


class Turning(LeafMotion):
    """On a hinge."""

    per_angle = 1.0

    def leaf(self, door_angle: float) -> tuple[float, float]:
        """Direction c: cos α along i, sin α along a. See `LeafMotion`.

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a.
        """
        return math.cos(door_angle), math.sin(door_angle)

    def normal(self, door_angle: float) -> tuple[float, float]:
        """Normal n: sin α along i, −cos α along a. See `LeafMotion`.

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a.
        """
        return math.sin(door_angle), -math.cos(door_angle)

    def bend(self, door_angle: float) -> tuple[float, float]:
        """Change of the normal, which is c. See `LeafMotion`.

        Args:
            door_angle: α [rad].

        Returns:
            Components along i and a [1/rad].
        """
        return self.leaf(door_angle)

    def way(self, door_angle: float) -> float:
        """Zero: a hinge does not move along i. See `LeafMotion`.

        Args:
            door_angle: α [rad].
        """
        return 0.0

    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        r"""Lever :math:`J = -D_V n - o\,c`. See `LeafMotion`.

        Args:
            door_angle: α [rad].
            distance: D_V [m].
            offset: o [m].

        Returns:
            Components along i and a [m].
        """
        (n_into, n_along), (c_into, c_along) = self.normal(door_angle), self.leaf(door_angle)
        return -(distance * n_into + offset * c_into), -(distance * n_along + offset * c_along)

    def lever_length(self, distance: float) -> float:
        """D_V itself [m]. See `LeafMotion`.

        Args:
            distance: D_V [m].
        """
        return distance

    def wind_lever(self, width: float) -> float:
        """Half the width: a wind presses on the middle of the leaf [m]. See `LeafMotion`.

        Args:
            width: Of the leaf, from its hinge [m].
        """
        return 0.5 * width

    def angle_of_face(self, before: float, distance: float) -> float:
        """Angle arcsin(before/D_V) [rad]. See `LeafMotion`.

        Args:
            before: So far [m].
            distance: D_V [m].
        """
        return math.asin(before / distance)

    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        r"""Angle :math:`\mathrm{atan2}(a^T r,\ i^T r) - \arcsin(o/|r|)` of a point at r from P_h [rad]. See `LeafMotion`.

        Args:
            into: Along i from P_h [m].
            along: Along a from P_h [m].
            offset: o [m].
            middle: Of the range of α, in which it is looked for [rad].
        """
        way = math.hypot(along, into)
        before = math.asin(min(max(offset / way, -1.0), 1.0)) if way > 0.0 else 0.0
        return middle + math.remainder(math.atan2(along, into) - before - middle, 2.0 * math.pi)

    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        """Torque :math:`w_n c_z - w_c n_z` [N m]. See `LeafMotion`.

        Args:
            weight: m g times the place of the centre of mass along c and n, shape (2,) [N m]; of a slide m g r at first.
            leaf_up: c_z.
            normal_up: n_z.
        """
        return float(weight[1] * leaf_up - weight[0] * normal_up)


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
