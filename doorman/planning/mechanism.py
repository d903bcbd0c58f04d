r"""One-joint mechanisms in CasADi symbols: where the contact is, which way its face looks, and what a force there moves.

With the joint's coordinate q, the contact point p, the face's outward normal n (towards the vehicle) and the lever J:

================ ============================================= =============================
symbol           revolute, axis a through o                     prismatic, axis a
================ ============================================= =============================
p(q)             :math:`o + \mathrm{Rot}(a, q)(p_0 - o)`        :math:`p_0 + a q`
n(q)             :math:`\mathrm{Rot}(a, q)\,n_0`                :math:`n_0`
J at a point x   :math:`a \times (x - o)`                       :math:`a`
================ ============================================= =============================

:math:`p_0` and :math:`n_0` are those at q = 0. A force F at x makes the torque, or force, :math:`J(x)^T F` in the joint, and so
does the weight at the centre of mass c: in the sense of damping :math:`G(q) = m g\,e_3^T J(c(q))`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import casadi as ca

from doorman.kinematics.symbols import rotation_about


class Mechanism(ABC):
    """Geometry of a mechanism, in the world frame."""

    @abstractmethod
    def carried(self, position: Any, direction: Any) -> Any:
        """A direction of the moving part."""

    @abstractmethod
    def moved(self, position: Any, point: Any) -> Any:
        """A point of the moving part, (3, 1) [m]."""

    @abstractmethod
    def lever(self, point: Any) -> Any:
        """J: how a point of the moving part moves with q, (3, 1) [m/rad, or 1]."""

    def weight_torque(self, position: Any, center: Any, weight: Any) -> Any:
        """Torque G(q) of a weight, in the sense of damping [N m, or N]."""
        return weight * self.lever(self.moved(position, center))[2]


class Revolute(Mechanism):
    """A hinge.

    Args:
        axis: a, a unit vector; plain numbers keep the expressions short, (3, 1).
        origin: o, any point of the axis, (3, 1) [m].
        sense: 1, or −1 where a growing q turns the other way about a; a symbol may say so in flight.
    """

    def __init__(self, axis: Any, origin: Any, sense: Any = 1.0) -> None:
        self._axis, self._origin, self._sense = ca.SX(axis), origin, sense

    def carried(self, position: Any, direction: Any) -> Any:
        r"""Direction turned by q, :math:`\mathrm{Rot}(a, q)\,d`. See `Mechanism`."""
        return rotation_about(self._axis, self._sense * position) @ direction

    def moved(self, position: Any, point: Any) -> Any:
        r"""Point on a circle about the axis, :math:`o + \mathrm{Rot}(a, q)(p - o)`. See `Mechanism`."""
        return self._origin + self.carried(position, point - self._origin)

    def lever(self, point: Any) -> Any:
        """Lever a × (x − o). See `Mechanism`."""
        return self._sense * ca.cross(self._axis, point - self._origin)


class Prismatic(Mechanism):
    """A slide.

    Args:
        axis: a, by which it moves with q, (3, 1) [1, or m/rad].
    """

    def __init__(self, axis: Any) -> None:
        self._axis = ca.SX(axis)

    def carried(self, position: Any, direction: Any) -> Any:
        """The direction itself: a slide does not turn. See `Mechanism`."""
        return direction

    def moved(self, position: Any, point: Any) -> Any:
        """Point on a line along the axis, :math:`p + a q`. See `Mechanism`."""
        return point + self._axis * position

    def lever(self, point: Any) -> Any:
        """Lever a, at any point. See `Mechanism`."""
        return self._axis


def mechanism_in_symbols(numbers: Any) -> Mechanism:
    """The mechanism of a task, by the numbers that it has (`mechanism_numbers`)."""
    if hasattr(numbers, "slide"):
        return Prismatic(numbers.slide)
    if hasattr(numbers, "axis"):
        return Revolute(numbers.axis, numbers.origin)
    return Revolute([0.0, 0.0, 1.0], numbers.origin, numbers.hand)
