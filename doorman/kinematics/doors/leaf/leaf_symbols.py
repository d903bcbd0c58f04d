r"""A door's leaf in CasADi symbols, as `leaf_motion` has it in numbers: where its face looks, and what the contact point does.

Which numbers a task has says how its leaf moves: a slide has `door.slide`, a hinge that is not vertical `door.up`. Vectors with
`in_heading` in their names are in the frame that looks along the vehicle's heading, z up.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import casadi as ca

CLOSED = 0.5 * math.pi
"""α of the closed door [rad]."""


class VerticalLeaf:
    r"""On a vertical hinge: only the difference of the leaf's azimuth and the heading enters.

    :math:`c = [\cos\beta,\ \sin\beta,\ 0]^T` with :math:`\beta = \psi_D + \sigma\alpha`.

    Args:
        door: Numbers of the door.
        contact: Numbers of the contact point.
        angle: α [rad].
        yaw: ψ of the vehicle [rad].
    """

    def __init__(self, door: Any, contact: Any, angle: Any, yaw: Any) -> None:
        self._door, self._contact, self._angle, self._yaw = door, contact, angle, yaw

    @cached_property
    def azimuth(self) -> Any:
        """β of the leaf, about z from the world's x axis [rad]."""
        return self._door.azimuth + self._door.hand * self._angle

    @cached_property
    def normal_in_heading(self) -> Any:
        """n_D, (3, 1)."""
        turn = self.azimuth - self._yaw
        return self._door.hand * ca.vertcat(ca.sin(turn), -ca.cos(turn), 0)

    @cached_property
    def leaf_in_heading(self) -> Any:
        """c, (3, 1)."""
        turn = self.azimuth - self._yaw
        return ca.vertcat(ca.cos(turn), ca.sin(turn), 0)

    @property
    def leaf_direction(self) -> Any:
        """c, (3, 1), world frame."""
        return ca.vertcat(ca.cos(self.azimuth), ca.sin(self.azimuth), 0)

    @property
    def normal(self) -> Any:
        """n_D, (3, 1), world frame."""
        return self._door.hand * ca.vertcat(ca.sin(self.azimuth), -ca.cos(self.azimuth), 0)

    @property
    def up(self) -> Any:
        """U along the hinge, (3, 1), world frame."""
        return ca.SX([0, 0, 1])

    @property
    def into_in_heading(self) -> Any:
        """Through the closed leaf, (3, 1)."""
        turn = self._door.azimuth - self._yaw
        return ca.vertcat(ca.cos(turn), ca.sin(turn), 0)

    @cached_property
    def contact_from_hinge(self) -> Any:
        """The contact point relative to P_h, (3, 1), world frame [m]."""
        contact = self._contact
        on_face = contact.distance_from_hinge * self.leaf_direction - contact.offset * self.normal
        return on_face + contact.height * self.up

    @property
    def lever(self) -> Any:
        """J of the contact point, (3, 1), world frame [m]."""
        return -self._contact.distance_from_hinge * self.normal - self._contact.offset * self.leaf_direction

    def lever_at(self, from_hinge: Any) -> Any:
        r"""J of any point of the leaf, :math:`\sigma u\times(x - P_h)`, (3, 1), world frame [m]."""
        return self._door.hand * ca.cross(self.up, from_hinge)

    @cached_property
    def lever_in_heading(self) -> Any:
        """J, (3, 1) [m]."""
        contact = self._contact
        return -contact.distance_from_hinge * self.normal_in_heading - contact.offset * self.leaf_in_heading

    def across(self, tip: Any) -> Any:
        """Distance of O_B from the hinge along the closed leaf [m]."""
        contact = self._contact
        of_contact = contact.distance_from_hinge * ca.sin(self._angle) + contact.offset * ca.cos(self._angle)
        return of_contact - ca.dot(self._door.along, tip)

    def into(self, tip_in_heading: Any) -> Any:
        """Distance of O_B behind the hinge through the doorway, negative before it [m]."""
        contact = self._contact
        of_contact = contact.distance_from_hinge * ca.cos(self._angle) - contact.offset * ca.sin(self._angle)
        return of_contact - ca.dot(self.into_in_heading, tip_in_heading)

    def in_heading(self, vector: Any) -> Any:
        """Components of a vector in the frame that looks along the vehicle's heading, z up."""
        s, c = ca.sin(self._yaw), ca.cos(self._yaw)
        return ca.vertcat(c * vector[0] + s * vector[1], c * vector[1] - s * vector[0], vector[2])

    def lift(self, weight: Any) -> Any:
        """Torque of a weight that hangs on the lever, in the sense of damping; 0 where the lever is horizontal [N m]."""
        return 0

    @property
    def weight_torque(self) -> Any:
        """G of the leaf's own weight, in the sense of damping [N m]."""
        return 0


class AnyLeaf(VerticalLeaf):
    """On a hinge of any direction: the door's axes are numbers, `door.into`, `door.along` and `door.up`. See `VerticalLeaf`."""

    @cached_property
    def normal(self) -> Any:
        """n_D, (3, 1), world frame."""
        return ca.sin(self._angle) * self._door.into - ca.cos(self._angle) * self._door.along

    @cached_property
    def leaf_direction(self) -> Any:
        """c, (3, 1), world frame."""
        return ca.cos(self._angle) * self._door.into + ca.sin(self._angle) * self._door.along

    @cached_property
    def normal_in_heading(self) -> Any:
        """n_D, (3, 1)."""
        return self.in_heading(self.normal)

    @cached_property
    def leaf_in_heading(self) -> Any:
        """c, (3, 1)."""
        return self.in_heading(self.leaf_direction)

    @property
    def up(self) -> Any:
        """U along the hinge, (3, 1), world frame."""
        return self._door.up

    @property
    def into_in_heading(self) -> Any:
        """Through the closed leaf, (3, 1)."""
        return self.in_heading(self._door.into)

    @cached_property
    def lever_in_heading(self) -> Any:
        """J, (3, 1) [m]."""
        return self.in_heading(self.lever)

    def across(self, tip: Any) -> Any:
        """Distance of O_B from the hinge along the closed leaf [m]. See `VerticalLeaf`."""
        return ca.dot(self._door.along, self.contact_from_hinge - tip)

    def into(self, tip_in_heading: Any) -> Any:
        """Distance of O_B behind the hinge through the doorway, negative before it [m]. See `VerticalLeaf`."""
        return ca.dot(self._door.into, self.contact_from_hinge) - ca.dot(self.into_in_heading, tip_in_heading)

    def lift(self, weight: Any) -> Any:
        r"""Torque :math:`w\,J_z` of a weight w that hangs on the lever, in the sense of damping [N m]."""
        return weight * self.lever[2]

    @property
    def weight_torque(self) -> Any:
        """G of the leaf's own weight, in the sense of damping [N m]."""
        return self._door.weight[1] * self.leaf_direction[2] - self._door.weight[0] * self.normal[2]


class SlidingLeaf(AnyLeaf):
    """On a slide: it keeps its direction, and moves by `door.slide` against `door.into` for a radian of α. See `VerticalLeaf`."""

    @property
    def normal(self) -> Any:
        """n_D, (3, 1), world frame."""
        return self._door.into

    @property
    def leaf_direction(self) -> Any:
        """c, (3, 1), world frame."""
        return self._door.along

    @cached_property
    def contact_from_hinge(self) -> Any:
        """The contact point relative to P_h, (3, 1), world frame [m]."""
        door, contact = self._door, self._contact
        before = contact.offset + door.slide * (self._angle - CLOSED)
        return contact.distance_from_hinge * door.along - before * door.into + contact.height * door.up

    @property
    def lever(self) -> Any:
        """J of the contact point, (3, 1), world frame [m]."""
        return -self._door.slide * self._door.into

    def lever_at(self, from_hinge: Any) -> Any:
        """J, the same of every point, (3, 1), world frame [m]."""
        return self.lever

    @property
    def weight_torque(self) -> Any:
        """G of the leaf's own weight, in the sense of damping [N m]."""
        return -self._door.weight[0] * self.normal[2]


def leaf_in_symbols(door: Any, contact: Any, angle: Any, yaw: Any) -> VerticalLeaf:
    """The leaf of a task, by the numbers that it has."""
    kind = SlidingLeaf if hasattr(door, "slide") else AnyLeaf if hasattr(door, "up") else VerticalLeaf
    return kind(door, contact, angle, yaw)
