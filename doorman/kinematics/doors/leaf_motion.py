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
        """Components of c."""

    @abstractmethod
    def normal(self, door_angle: float) -> tuple[float, float]:
        """Components of n."""

    @abstractmethod
    def bend(self, door_angle: float) -> tuple[float, float]:
        """Components of dn/dα."""

    @abstractmethod
    def way(self, door_angle: float) -> float:
        """Of the leaf against i [m]."""

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
        """See `LeafMotion`."""
        return math.cos(door_angle), math.sin(door_angle)

    def normal(self, door_angle: float) -> tuple[float, float]:
        """See `LeafMotion`."""
        return math.sin(door_angle), -math.cos(door_angle)

    def bend(self, door_angle: float) -> tuple[float, float]:
        """It is c. See `LeafMotion`."""
        return self.leaf(door_angle)

    def way(self, door_angle: float) -> float:
        """None. See `LeafMotion`."""
        return 0.0

    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        """See `LeafMotion`."""
        (n_into, n_along), (c_into, c_along) = self.normal(door_angle), self.leaf(door_angle)
        return -(distance * n_into + offset * c_into), -(distance * n_along + offset * c_along)

    def lever_length(self, distance: float) -> float:
        """See `LeafMotion`."""
        return distance

    def wind_lever(self, width: float) -> float:
        """On the middle of the leaf. See `LeafMotion`."""
        return 0.5 * width

    def angle_of_face(self, before: float, distance: float) -> float:
        """See `LeafMotion`."""
        return math.asin(before / distance)

    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        """See `LeafMotion`."""
        way = math.hypot(along, into)
        before = math.asin(min(max(offset / way, -1.0), 1.0)) if way > 0.0 else 0.0
        return middle + math.remainder(math.atan2(along, into) - before - middle, 2.0 * math.pi)

    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        """See `LeafMotion`."""
        return float(weight[1] * leaf_up - weight[0] * normal_up)


class Sliding(LeafMotion):
    """Along i."""

    per_angle = SLIDE_RADIUS

    def leaf(self, door_angle: float) -> tuple[float, float]:
        """See `LeafMotion`."""
        return 0.0, 1.0

    def normal(self, door_angle: float) -> tuple[float, float]:
        """See `LeafMotion`."""
        return 1.0, 0.0

    def bend(self, door_angle: float) -> tuple[float, float]:
        """None. See `LeafMotion`."""
        return 0.0, 0.0

    def way(self, door_angle: float) -> float:
        """See `LeafMotion`."""
        return self.per_angle * (door_angle - 0.5 * math.pi)

    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        """See `LeafMotion`."""
        return -self.per_angle, 0.0

    def lever_length(self, distance: float) -> float:
        """See `LeafMotion`."""
        return self.per_angle

    def wind_lever(self, width: float) -> float:
        """See `LeafMotion`."""
        return self.per_angle

    def angle_of_face(self, before: float, distance: float) -> float:
        """See `LeafMotion`."""
        return before / self.per_angle

    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        """See `LeafMotion`."""
        return 0.5 * math.pi - (into + offset) / self.per_angle

    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        """See `LeafMotion`."""
        return float(-weight[0] * normal_up)
