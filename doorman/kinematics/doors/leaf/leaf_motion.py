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
        """Direction of the leaf, c(α)."""

    @abstractmethod
    def normal(self, door_angle: float) -> tuple[float, float]:
        """Normal of the leaf, n(α)."""

    @abstractmethod
    def normals(self, door_angles: Array) -> Array:
        """Normals at many angles."""

    @abstractmethod
    def bend(self, door_angle: float) -> tuple[float, float]:
        """Change of the normal with α, dn/dα."""

    @abstractmethod
    def way(self, door_angle: float) -> float:
        """How far the leaf has moved against i, from closed [m]."""

    @abstractmethod
    def lever(self, door_angle: float, distance: float, offset: float) -> tuple[float, float]:
        """Components of J."""

    @abstractmethod
    def lever_length(self, distance: float) -> float:
        """Speed of the contact point along the normal for a unit rate of α [m]."""

    @abstractmethod
    def wind_lever(self, width: float) -> float:
        """Torque in the joint for each newton that a wind presses on the face with [m]."""

    @abstractmethod
    def angle_of_face(self, before: float, distance: float) -> float:
        """By how much α of a point is less if the face stands before its place [rad]."""

    @abstractmethod
    def angle_of(self, into: float, along: float, offset: float, middle: float) -> float:
        """α at which a point is on the face [rad]."""

    @abstractmethod
    def weight_torque(self, weight: Array, leaf_up: float, normal_up: float) -> float:
        """G [N m]."""
