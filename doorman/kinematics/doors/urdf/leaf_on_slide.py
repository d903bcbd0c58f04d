"""What a URDF says of a leaf on a slide, as of a drawer or a sliding door: which way it goes, and what stands beside its way."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.doors.urdf.convention import Closed, closed_near_zero
from doorman.kinematics.doors.urdf.leaf_in_plane import LeafInPlane, turns_in_plane
from doorman.kinematics.doors.urdf.leaf_on_joint import LeafOnJoint, LeafSize
from doorman.scenario import ContactSection, DoorSection

_UP = np.array([0.0, 0.0, 1.0])
_STEEPEST = math.sin(math.radians(30.0))
"""Largest upward component of a slide that is moved by tilting."""


class LeafOnSlide(LeafOnJoint):
    """Reader of one slide: `along` is horizontal in its face, P_h its lower corner where it is closed. See `LeafOnJoint`."""

    unit = "m"
    _upright = False

    def direction(self, value: float) -> Array:
        """Horizontal unit vector across the slide, in the face."""
        across = np.cross(_UP, self.axis)
        return np.asarray(across / np.linalg.norm(across))

    def directions(self, closed: float, sense: float) -> tuple[Array, Array]:
        """Direction across the slide, and the one in which the leaf moves as it opens."""
        return self.direction(closed), sense * self.axis

    def up(self, into: Array, along: Array) -> Array:
        """Unit vector in the face, at a right angle to `along`, upwards."""
        up = np.cross(into, along)
        return np.asarray(up * np.sign(up[2]))

    def size(self, axes: Array, closed: float) -> LeafSize:
        """Size of the leaf, seen along the slide."""
        middle, reach = self._placed(axes, closed)
        sides = float(2 * reach[1]), float(2 * reach[2]), float(2 * reach[0]), 0.0
        return LeafSize(sides, (middle - reach) @ axes)

    def face_offset(self, axes: Array, closed: float, place: tuple[float, float]) -> float:
        """How far the face lies before P_h, along and up from it [m]."""
        into, along, up = axes @ self.rotation(closed)
        at = place[0] + self.shape.extent(along)[0], place[1] + self.shape.extent(up)[0]
        return self.shape.extent(into)[0] - self.shape.face(into, along, up, at)

    def beside(self, axes: Array, closed: float, point: Array) -> tuple[Array, float] | None:
        """Plane beside the way of a contact point that lies before the leaf's side, or above it, and not on its front.

        Boxes that stand still count where the point is beyond them as well.
        """
        middle, reach = self._placed(axes, closed)
        away = axes @ point - middle
        outside = np.abs(away) - reach
        side = 1 + int(np.argmax(outside[1:]))
        if outside[side] <= 0.0:
            return None
        normal = np.sign(away[side]) * axes[side]
        own = float(np.sign(away[side]) * middle[side] + reach[side])
        return normal, max([own, *self._planes_behind(normal, point)])

    def _placed(self, axes: Array, closed: float) -> tuple[Array, Array]:
        """Centre from the world's origin and half lengths of the leaf along the doorway's axes, (3,) each [m]."""
        into, along, up = axes @ self.rotation(closed)
        reaches = np.array([self.shape.extent(into), self.shape.extent(along), self.shape.extent(up)])
        reaches += (axes @ np.array(self._data.oMi[1].translation))[:, None]
        return reaches.mean(axis=1), 0.5 * np.ptp(reaches, axis=1)

    def _axis_in_world(self) -> Array:
        """Unit vector along which the leaf slides, world frame; plainly horizontal where it is nearly so."""
        places = []
        for value in (0.0, 1.0):
            pinocchio.forwardKinematics(self._model, self._data, np.array([value]))
            places.append(np.array(self._data.oMi[1].translation))
        axis = np.round(places[1] - places[0], 9)
        if abs(axis[2]) > _STEEPEST:
            raise UrdfError(
                "the slide is too steep: a vehicle moves it by tilting", file=self._urdf,
                field=f"joint {self._section.hinge}", given=f"axis along {axis.round(4).tolist()} in the world",
                allowed=f"within {math.degrees(math.asin(_STEEPEST)):.0f}° of the horizontal",
            )  # fmt: skip
        return np.asarray(axis / np.linalg.norm(axis))

    def _inertia_along_the_joint(self) -> float:
        """The mass [kg]."""
        return float(self._model.inertias[1].mass)

    def _likely_closed(self) -> Closed:
        return closed_near_zero(self.limits)


def read_leaf(
    urdf: Path, model: pinocchio.Model, section: DoorSection, contact: ContactSection | None = None
) -> LeafOnJoint:
    """Reader of a door, by the kind of its joint."""
    if model.joints[1].shortname().startswith("JointModelP"):
        return LeafOnSlide(urdf, model, section)
    leaf = LeafOnJoint(urdf, model, section)
    return LeafInPlane(urdf, model, section, contact) if turns_in_plane(leaf, contact) else leaf
