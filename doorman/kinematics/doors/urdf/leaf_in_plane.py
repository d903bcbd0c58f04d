"""What a URDF says of a lever, a knob or a valve: it turns in the plane of the face that it stands on."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.doors.urdf.convention import Closed, closed_near_zero
from doorman.kinematics.doors.urdf.leaf_on_joint import LEANS, UP, LeafOnJoint, LeafSize

_FLAT = 0.5
"""Largest length along the axis of what turns in a plane, as a share of its reach across: a hatch is longer along its hinge."""
_PLATE = 3.0
"""Least length of a plate's sides, as a multiple of its thickness: a leaf, a wall or a panel, and no jamb."""
ALONG = math.cos(math.radians(5.0))
"""Least cosine between a contact's normal and the direction away from leaf or face in which it looks."""


class LeafInPlane(LeafOnJoint):
    """Reader of one lever, knob or valve. See `LeafOnJoint`.

    `along` leads from the axis to the contact, or along the lever where none is named; `up` looks away from the face, to the
    vehicle. So the normal is the way on which the tip moves, about the axis.
    """

    def _direction(self, value: float) -> Array:
        """Unit vector at a right angle to the axis: to the contact, else along the lever, else anywhere."""
        if self.named is not None:
            return self._across(self._contact_place(value))
        along = self.shape.along
        if along is None:
            along = np.roll(np.eye(3), 1, axis=0)[np.argmax(np.abs(self.shape.axis))]
        return self._across(self.rotation(value) @ along)

    def _up(self, into: Array, along: Array) -> Array:
        """Away from the face."""
        return -self._face()

    @cached_property
    def size(self) -> LeafSize:
        """Reach from the axis, length along it, and thickness."""
        into, along, up = self.axes_in_leaf
        lowest, highest = self._whole(up)
        width, (front, back) = self._whole(along)[1], self.shape.extent(into)
        if self.named is not None:  # a round rim is read as a polygon
            _, far, high = self.axes @ self._contact_place(self.closed.value)
            width, lowest, highest = max(width, float(far)), min(lowest, float(high)), max(highest, float(high))
        sides = width, highest - lowest, back - front, 0.0 - front
        return LeafSize(sides, self.origin + lowest * self.axes[2])

    def frame_depth(self) -> tuple[float, float]:
        """None: the vehicle stays before the face."""
        return 0.0, 0.0

    def beside(self, point: Array) -> tuple[Array, float]:
        """Plane of the face: of what stands still behind the contact, else of the back of what turns."""
        normal = self.axes[2]
        behind = float(normal @ self.origin) + self._whole(self.axes_in_leaf[2])[0]
        return normal, max(self._planes_behind(normal, point), default=behind)

    def _whole(self, direction: Array) -> tuple[float, float]:
        """From where to where all parts reach along a unit vector [m]."""
        reaches = np.array([part.extent(direction) for part in self.shape.parts])
        return float(reaches[:, 0].min()), float(reaches[:, 1].max())

    def _contact_place(self, value: float) -> Array:
        """From the joint [m]."""
        return np.asarray(self.contact(value, -UP)[0] - self.origin)

    def _face(self) -> Array:
        """From the vehicle to the face: where what the axis passes stands, or what is nearest; without anything, along x."""
        closed = self.closed.value
        if self.named is not None:
            at = float(self.axis @ self._contact_place(closed))
        else:
            at = 0.5 * sum(self._whole(self.rotation(closed).T @ self.axis))
        passed = (self._along_axis(*box) for box in self.fixed_boxes if passes(self.origin, self.axis, *box))
        plates = [(abs(middle - at) - half, middle - at) for middle, half in passed]
        side = min(plates)[1] if plates else float(self.axis[0]) or 1.0
        return np.asarray(math.copysign(1.0, side) * self.axis)

    def _along_axis(self, placed: Array, size: Array) -> tuple[float, float]:
        """Middle and half length of a box along the axis, from the joint [m]."""
        middle = float(self.axis @ (placed[:3, 3] - self.origin))
        return middle, float(np.abs(self.axis @ placed[:3, :3]) @ size / 2)

    def _turn(self) -> tuple[float, float]:
        closed = self._section.closed or 0.0
        return closed - math.pi, closed + math.pi

    def _likely_closed(self) -> Closed:
        return closed_near_zero(self.limits)


def turns_in_plane(leaf: LeafOnJoint) -> bool:
    """Whether a hinge's axis stands at a right angle to the face that it is mounted on, as a lever's does."""
    axis, shape, named = leaf.axis, leaf.shape, leaf.named
    if abs(axis[2]) >= LEANS:
        return False
    if named is not None:
        outward = leaf.contact(0.0, -UP)[1]
        if named.link is None and outward is not None and abs(float(outward @ axis)) > ALONG:
            return True
    height, across = shape.width(shape.axis), [shape.width(edge) for edge in _across(shape.axis)]
    if height > _FLAT * max(across):
        return False
    plates = (box for box in leaf.fixed_boxes if passes(leaf.origin, axis, *box))
    return height <= min(across) or any(_is_plate(axis, *plate) for plate in plates)


def passes(origin: Array, axis: Array, placed: Array, size: Array) -> bool:
    """Whether a line passes through a box."""
    start, way = placed[:3, :3].T @ (origin - placed[:3, 3]), placed[:3, :3].T @ axis
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.nan_to_num((np.outer([-0.5, 0.5], size) - start) / way, nan=0.0), axis=0)
    beside = (np.abs(way) < 1e-9) & (np.abs(start) > size / 2)
    return bool(not beside.any() and ends[0].max() <= ends[1].min())


def _is_plate(axis: Array, placed: Array, size: Array) -> bool:
    """Whether a box is thin along an axis, and wide across it."""
    thin = int(np.argmax(np.abs(axis @ placed[:3, :3])))
    return bool((np.delete(size, thin) >= _PLATE * size[thin]).all())


def _across(axis: Array) -> Array:
    """Directions at a right angle to an axis, half a turn of them, shape (12, 3)."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    angles = np.linspace(0.0, math.pi, 12, endpoint=False)[:, None]
    return np.asarray(np.cos(angles) * first + np.sin(angles) * np.cross(axis, first))
