r"""A door's leaf in CasADi symbols, by the lines of `leaf_motion`: where its face looks, and what the contact point does.

Which numbers a task has says how its leaf moves: a slide has `door.slide`, a hinge that is not vertical `door.up`. Vectors with
`in_heading` in their names are in the frame that looks along the vehicle's heading, z up.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from doorman.kinematics.doors.leaf import leaf_motion as motion


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
        self._slide: Any = getattr(door, "slide", 0.0)
        self._turn = 0.0 if hasattr(door, "slide") else 1.0

    @cached_property
    def azimuth(self) -> Any:
        """β of the leaf, about z from the world's x axis [rad]."""
        return self._door.azimuth + self._door.hand * self._angle

    @property
    def _in_heading(self) -> tuple[Any, Any]:
        """Direction c and normal n_D, (3, 1) each, as seen along the vehicle's heading."""
        return self._seen(self.azimuth - self._yaw)

    def _seen(self, turn: Any) -> tuple[Any, Any]:
        """The same, of a leaf that points there [rad]."""
        cosine, sine = ca.cos(turn), ca.sin(turn)
        leaf = ca.vertcat(*motion.leaf_in_doorway(cosine, sine), 0)
        return leaf, self._door.hand * ca.vertcat(*motion.normal_in_doorway(cosine, sine), 0)

    @cached_property
    def normal_in_heading(self) -> Any:
        """n_D, (3, 1)."""
        return self._in_heading[1]

    @cached_property
    def leaf_in_heading(self) -> Any:
        """c, (3, 1)."""
        return self._in_heading[0]

    @cached_property
    def leaf_direction(self) -> Any:
        """c, (3, 1), world frame."""
        return self._seen(self.azimuth)[0]

    @cached_property
    def normal(self) -> Any:
        """n_D, (3, 1), world frame."""
        return self._seen(self.azimuth)[1]

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
        before = contact.offset + motion.way(self._slide, self._angle)
        return motion.contact_from_hinge(
            contact.distance_from_hinge, before, contact.height, self.leaf_direction, self.normal, self.up
        )

    @property
    def lever(self) -> Any:
        """J of the contact point, (3, 1), world frame [m]."""
        return self._lever(self.leaf_direction, self.normal)

    def _lever(self, leaf: Any, normal: Any) -> Any:
        contact = self._contact
        return motion.lever(self._turn, self._slide, contact.distance_from_hinge, contact.offset, leaf, normal)

    def lever_at(self, from_hinge: Any) -> Any:
        r"""J of any point of the leaf, :math:`t\,\sigma u\times(x - P_h) - s\,n`, (3, 1), world frame [m]."""
        return self._turn * self._door.hand * ca.cross(self.up, from_hinge) - self._slide * self.normal

    @cached_property
    def lever_in_heading(self) -> Any:
        """J, (3, 1) [m]."""
        return self._lever(self.leaf_in_heading, self.normal_in_heading)

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
    """On a slide, or a hinge of any direction, by the axes `door.into`, `door.along` and `door.up`. See `VerticalLeaf`."""

    @cached_property
    def _turned(self) -> tuple[Any, Any]:
        """Cosine and sine of α'."""
        angle = motion.turned(self._turn, self._angle)
        return ca.cos(angle), ca.sin(angle)

    def _in_world(self, parts: tuple[Any, Any]) -> Any:
        return parts[0] * self._door.into + parts[1] * self._door.along

    @cached_property
    def normal(self) -> Any:
        """n_D, (3, 1), world frame."""
        return self._in_world(motion.normal_in_doorway(*self._turned))

    @cached_property
    def leaf_direction(self) -> Any:
        """c, (3, 1), world frame."""
        return self._in_world(motion.leaf_in_doorway(*self._turned))

    @property
    def _in_heading(self) -> tuple[Any, Any]:
        """Direction c and normal n_D, (3, 1) each, as seen along the vehicle's heading."""
        return self.in_heading(self.leaf_direction), self.in_heading(self.normal)

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

    def lift(self, weight: Any) -> Any:
        r"""Torque :math:`w\,J_z` of a weight w that hangs on the lever, in the sense of damping [N m]."""
        return weight * self.lever[2]

    @property
    def weight_torque(self) -> Any:
        """G of the leaf's own weight, in the sense of damping [N m]."""
        weight = self._door.weight
        return motion.weight_torque(weight[0], weight[1], self.leaf_direction[2], self.normal[2])


def leaf_in_symbols(door: Any, contact: Any, angle: Any, yaw: Any) -> VerticalLeaf:
    """The leaf of a task, by the numbers that it has."""
    return (AnyLeaf if hasattr(door, "up") else VerticalLeaf)(door, contact, angle, yaw)
