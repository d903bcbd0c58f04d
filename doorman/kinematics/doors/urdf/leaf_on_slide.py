"""What a URDF says of a leaf on a slide, as of a drawer or a sliding door: which way it goes, and what stands beside its way."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.doors.urdf.convention import Closed, closed_near_zero
from doorman.kinematics.doors.urdf.leaf_in_plane import LeafInPlane, turns_in_plane
from doorman.kinematics.doors.urdf.leaf_on_joint import LEANS, UP, LeafOnJoint, LeafSize
from doorman.scenario import ContactSection, DoorSection


class LeafOnSlide(LeafOnJoint):
    """Reader of one slide: `along` is horizontal in its face, P_h its lower corner where it is closed. See `LeafOnJoint`."""

    unit = "m"
    _upright = False

    def _directions(self) -> tuple[Array, Array]:
        """Horizontal direction across the slide, in the face, and the one in which the leaf moves as it opens."""
        across = np.cross(UP, self.axis)
        return np.asarray(across / np.linalg.norm(across)), self.sense * self.axis

    def _up(self, into: Array, along: Array) -> Array:
        """Unit vector in the face, at a right angle to `along`, upwards."""
        up = np.cross(into, along)
        return np.asarray(up * np.sign(up[2]))

    @cached_property
    def size(self) -> LeafSize:
        """Size of the leaf, seen along the slide."""
        middle, reach = self._placed
        sides = float(2 * reach[1]), float(2 * reach[2]), float(2 * reach[0]), 0.0
        return LeafSize(sides, (middle - reach) @ self.axes)

    def face_offset(self, place: tuple[float, float]) -> float:
        """How far the face lies before P_h, along and up from it [m]."""
        into, along, up = self.axes_in_leaf
        at = place[0] + self.shape.extent(along)[0], place[1] + self.shape.extent(up)[0]
        return self.shape.extent(into)[0] - self.shape.face(into, along, up, at)

    def beside(self, point: Array) -> tuple[Array, float] | None:
        """Plane beside the way of a contact point that lies before the leaf's side, or above it, and not on its front.

        Boxes that stand still count where the point is beyond them as well.
        """
        middle, reach = self._placed
        away = self.axes @ point - middle
        outside = np.abs(away) - reach
        side = 1 + int(np.argmax(outside[1:]))
        if outside[side] <= 0.0:
            return None
        normal = np.sign(away[side]) * self.axes[side]
        own = float(np.sign(away[side]) * middle[side] + reach[side])
        return normal, max([own, *self._planes_behind(normal, point)])

    @cached_property
    def _placed(self) -> tuple[Array, Array]:
        """Centre from the world's origin and half lengths of the leaf along the doorway's axes, (3,) each [m]."""
        reaches = np.array([self.shape.extent(axis) for axis in self.axes_in_leaf])
        reaches += (self.axes @ np.array(self._at(self.closed.value).translation))[:, None]
        return reaches.mean(axis=1), 0.5 * np.ptp(reaches, axis=1)

    def _axis_in_world(self) -> Array:
        """Unit vector along which the leaf slides, world frame; plainly horizontal where it is nearly so."""
        first, last = (np.array(self._at(value).translation) for value in (0.0, 1.0))
        axis = np.round(last - first, 9)
        if abs(axis[2]) > LEANS:
            raise UrdfError(
                "the slide is too steep: a vehicle moves it by tilting", file=self._urdf,
                field=f"joint {self._section.hinge}", given=f"axis along {axis.round(4).tolist()} in the world",
                allowed=f"within {math.degrees(math.asin(LEANS)):.0f}° of the horizontal",
            )  # fmt: skip
        return np.asarray(axis / np.linalg.norm(axis))

    def _inertia_along_the_joint(self) -> float:
        """The mass [kg]."""
        return float(self._model.inertias[1].mass)

    def _likely_closed(self) -> Closed:
        return closed_near_zero(self.limits)


def read_leaf(
    urdf: Path, model: pinocchio.Model, section: DoorSection, contact: ContactSection | None, turns: float
) -> LeafOnJoint:
    """Reader of a door, by the kind of its joint."""
    if model.joints[1].shortname().startswith("JointModelP"):
        return LeafOnSlide(urdf, model, section, contact, turns)
    leaf = LeafOnJoint(urdf, model, section, contact, turns)
    return LeafInPlane(urdf, model, section, contact, turns) if turns_in_plane(leaf) else leaf
