r"""How the leaf's link moves, for a joint value from its pose.

With the link's placement :math:`T_0` where the joint is at zero, a unit axis a and a point c on it, a hinge at q has
:math:`T(q) = t(c)\,R_a(q)\,t(-c)\,T_0`, and a slide :math:`T(q) = t(q a)\,T_0`.
A seen pose T gives q twice: by its rotation, and by where
the mark is. Both are weighed by their deviations: a mark 0.7 m from the hinge says more by its place than by its attitude.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.doors.door import Door

Triple = tuple[float, float, float]

_QUARTER = 0.5 * math.pi
_ENDLESS = 1e6
"""Beyond what any joint of a door comes to: JSON knows no infinity."""


@dataclass(frozen=True)
class LeafGeometry:
    """Motion of a leaf's link in the world of its URDF; make one with `of`."""

    position: Triple
    """Position of the link at joint value 0 [m]."""
    rotation: tuple[Triple, Triple, Triple]
    """Rotation of the link there, as rows."""
    axis: Triple
    """Unit vector about which the leaf turns, or along which it slides, as the joint's value grows."""
    point: Triple
    """On the hinge's axis [m]."""
    slides: bool
    limits: tuple[float, float] = (-_ENDLESS, _ENDLESS)
    """Range of the joint's value [rad, or m]."""
    door_position: Triple = (0.0, 0.0, 0.0)
    """Where the map has the origin of the door's URDF [m]."""
    door_yaw: float = 0.0
    """Yaw of the door in the map [rad]."""

    @classmethod
    def of(cls, door: Door) -> LeafGeometry:
        """That of a door, as its URDF has it.

        Args:
            door: The map's.
        """
        back = np.linalg.inv(door.placement)
        zero, turned = (
            back @ door.link_placements(door.angle_of_joint(value))[door.section.leaf] for value in (0.0, _QUARTER)
        )
        hinge = (back @ [*door.hinge_position, 1.0])[:3]
        axis = turned[:3, 3] - zero[:3, 3] if door.slides else pin.log3(turned[:3, :3] @ zero[:3, :3].T)
        axis = axis / np.linalg.norm(axis)
        rows = [_triple(row) for row in zero[:3, :3]]
        ends = sorted(door.joint_value(angle) for angle in (door.lower_limit, door.upper_limit))
        limits = (ends[0], ends[1]) if ends[0] < ends[1] and not door.endless else (-_ENDLESS, _ENDLESS)
        return cls(
            _triple(zero[:3, 3]), (rows[0], rows[1], rows[2]), _triple(axis), _triple(hinge), door.slides,
            limits, _triple(door.placement[:3, 3]), door.yaw,
        )  # fmt: skip

    def placement(self, joint: float) -> tuple[Array, Array]:
        """Position and rotation of the link at a joint value.

        Args:
            joint: q [rad, or m].

        Returns:
            Shapes (3,) and (3, 3).
        """
        place, turn = np.array(self.position), np.array(self.rotation)
        if self.slides:
            return place + joint * np.array(self.axis), turn
        moved, point = pin.exp3(joint * np.array(self.axis)), np.array(self.point)
        return point + moved @ (place - point), moved @ turn

    def joint(
        self, position: Array, rotation: Array, mark: ArrayLike, place_deviation: float, turn_deviation: float
    ) -> tuple[float, float, float, float]:
        """Joint value of a seen link.

        Args:
            position: Of the link, shape (3,), in the world of the door's URDF [m].
            rotation: Of the link there, shape (3, 3).
            mark: Where the mark is that was seen, shape (3,), in the link [m].
            place_deviation: Of the mark's place [m].
            turn_deviation: Of its attitude [rad].

        Returns:
            The value and its deviation [rad, or m]; how far the mark is from where this value has it [m], and by how much the
            link is turned against it [rad].
        """
        axis, spot = np.array(self.axis), position + rotation @ np.asarray(mark, float)
        zero = np.array(self.position) + np.array(self.rotation) @ np.asarray(mark, float)
        if self.slides:
            value, deviation = float(axis @ (spot - zero)), place_deviation
        else:
            point = np.array(self.point)
            before, now = (one - point - axis * (axis @ (one - point)) for one in (zero, spot))
            by_place = math.atan2(float(axis @ np.cross(before, now)), float(before @ now))
            turned = rotation @ np.array(self.rotation).T
            spin = np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]])
            along = float(axis @ turned @ axis)
            by_turn = math.atan2(float(axis @ spin), float(np.trace(turned)) - along)
            lever = float(np.linalg.norm(before))
            weights = (lever / place_deviation) ** 2, 1.0 / turn_deviation**2
            apart = math.remainder(by_turn - by_place, 2.0 * math.pi)
            value = by_place + apart * weights[1] / sum(weights)
            deviation = 1.0 / math.sqrt(sum(weights))
        there, turn = self.placement(value)
        rest = turn.T @ rotation
        off = float(np.linalg.norm(spot - there - turn @ np.asarray(mark, float)))
        return value, deviation, off, float(np.linalg.norm(pin.log3(rest)))


def _triple(values: Array) -> Triple:
    x, y, z = values.tolist()
    return (x, y, z)
