"""What a door's URDF says of the leaf on its joint: which way it turns and points, where it is closed, what stands beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.exceptions import UrdfError
from doorman.kinematics.door_convention import FixedBox, closed_value, meets
from doorman.kinematics.urdf import link_index
from doorman.kinematics.urdf_elements import read_boxes
from doorman.scenario import DoorSection

Array = NDArray[np.float64]

_VERTICAL = math.cos(math.radians(0.25))
"""Least upward component of an axis or an edge that counts as vertical: gravity turns a leaf that leans so by little."""


@dataclass(frozen=True)
class LeafSize:
    """The leaf's largest box, seen from its joint."""

    sides: tuple[float, float, float, float]
    """Width from the hinge, height, thickness, and how far the face to the vehicle lies before the hinge axis [m]."""
    lower_edge: float
    """Above the joint's origin [m]."""


class LeafOnJoint:
    """Reader of one door.

    Args:
        urdf: Path of the URDF.
        model: Pinocchio's of it, in which the hinge alone moves.
        section: Names, and where the joint is closed if that is said.

    Raises:
        UrdfError: if the hinge has no range or is not vertical, or the leaf has no box.
    """

    def __init__(self, urdf: Path, model: pinocchio.Model, section: DoorSection) -> None:
        self._urdf, self._model, self._section = urdf, model, section
        self._data = model.createData()
        self.origin = np.array(model.jointPlacements[1].translation)
        """Of the joint, shape (3,), world frame [m]."""
        self.limits = self._range()
        """Of the joint [rad]."""
        self._box = self._largest_box()
        self._axis = self._vertical_axis()

    def rotation(self, value: float) -> Array:
        """Rotation of the leaf's joint frame into the world at a joint value, (3, 3)."""
        pinocchio.forwardKinematics(self._model, self._data, np.array([value]))
        return np.array(self._data.oMi[1].rotation)

    def direction(self, value: float) -> Array:
        """Horizontal unit vector along the leaf, away from the hinge, at a joint value."""
        center, edges, size = self._box
        rotation = self.rotation(value)
        turned, way = rotation @ edges, rotation @ center
        upright = int(np.argmax(np.abs(turned[2])))
        if abs(turned[2, upright]) < _VERTICAL:
            raise UrdfError(
                "the leaf does not stand upright", file=self._urdf, field=f"link {self._section.leaf}/collision",
                given=f"edges along {turned.T.round(3).tolist()}", allowed="a box with vertical edges",
            )  # fmt: skip
        longest = max((i for i in range(3) if i != upright), key=lambda i: size[i])
        direction = turned[:, longest] * np.sign(turned[:, longest] @ way or 1.0) * [1.0, 1.0, 0.0]
        return np.round(direction, 9) / np.linalg.norm(np.round(direction, 9))

    def closed(self) -> tuple[float, float]:
        """Joint value of the closed door [rad], and 1 where it grows as the door opens, else −1.

        Raises:
            UrdfError: if the scenario's value is outside of the range, or it is not clear which one it is.
        """
        lower, upper = self.limits
        closed = self._section.closed
        if closed is None:
            closed = self._at_a_jamb()
        elif not lower - 1e-3 <= closed <= upper + 1e-3:
            raise UrdfError(
                "closed outside the hinge's range", file=self._urdf, field="door.closed", given=closed,
                allowed=f"{lower:g} to {upper:g} rad",
            )  # fmt: skip
        return closed, 1.0 if upper - closed > closed - lower else -1.0

    def directions(self, closed: float, sense: float) -> tuple[Array, Array]:
        """Along the closed leaf from hinge to latch, and the horizontal way that it swings as it opens."""
        along = self.direction(closed)
        into = sense * np.sign(self._axis[2]) * np.array([-along[1], along[0], 0.0])
        return along, into

    def mass_and_inertia(self) -> tuple[float, float]:
        """Of what the joint carries, its inertia about the joint's axis [kg], [kg m²].

        Raises:
            UrdfError: if there is none.
        """
        carried, axis = self._model.inertias[1], self.rotation(0.0).T @ self._axis
        mass, about_hinge = float(carried.mass), float(axis @ carried.matrix()[3:, 3:] @ axis)
        for name, value, unit in (("mass", mass, "kg"), ("inertia", about_hinge, "kg m² about the hinge")):
            if not value > 0.0:
                raise UrdfError(
                    f"the leaf has no {name}", file=self._urdf, field=f"link {self._section.leaf}/inertial/{name}",
                    given=value, allowed=f"> 0 {unit}",
                )  # fmt: skip
        return mass, about_hinge

    def size(self, axes: Array, closed: float) -> LeafSize:
        """Size of the leaf.

        Args:
            axes: From the world to the doorway, (3, 3).
            closed: Joint value of the closed door [rad].

        Raises:
            UrdfError: if the box does not reach away from the hinge.
        """
        center, edges, size = self._box
        turned = axes @ self.rotation(closed)
        middle, reach = turned @ center, np.abs(turned @ edges) @ size / 2
        if middle[1] <= 0.0 or reach[0] > reach[1]:
            raise UrdfError(
                "the leaf does not reach away from its hinge", file=self._urdf, field=f"link {self._section.leaf}/collision",
                given=f"a box of {np.round(2 * reach, 4).tolist()} m around {middle.round(4).tolist()} m, across, along, up",
                allowed="a leaf that is longer than thick and lies beside the hinge",
            )  # fmt: skip
        sides = float(middle[1] + reach[1]), float(2 * reach[2]), float(2 * reach[0]), float(reach[0] - middle[0])
        return LeafSize(sides, float(middle[2] - reach[2]))

    def frame_depth(self, axes: Array, width: float) -> tuple[float, float]:
        """How far boxes beside the doorway, that do not move with the leaf, reach before and behind the hinge axis [m].

        Args:
            axes: From the world to the doorway, (3, 3).
            width: Of the leaf [m].

        Returns:
            Not negative; 0 without any.
        """
        middle, nearest, farthest = 0.5 * width, [0.0], [0.0]
        for placed, size in self._fixed_boxes():
            center = axes @ (placed[:3, 3] - self.origin)
            half = np.abs(axes @ placed[:3, :3]) @ size / 2
            if abs(center[1] - middle) > half[1]:
                nearest.append(float(center[0] - half[0]))
                farthest.append(float(center[0] + half[0]))
        return -min(nearest), max(farthest)

    def frame(self, name: str, value: float) -> tuple[Array, Array]:
        """Origin and x axis of a frame on the leaf at a joint value, (3,) each, world frame [m].

        Raises:
            UrdfError: if there is no such frame, or it does not move with the leaf.
        """
        index = link_index(self._model, name, self._urdf, "contact.frame")
        if self._model.frames[index].parentJoint != 1:
            raise UrdfError(
                "the contact frame does not move with the leaf", file=self._urdf, field="contact.frame", given=name,
                allowed=f"a link that joint '{self._section.hinge}' moves",
            )  # fmt: skip
        pinocchio.framesForwardKinematics(self._model, self._data, np.array([value]))
        placement = self._data.oMf[index]
        return np.array(placement.translation), np.array(placement.rotation[:, 0])

    def _range(self) -> tuple[float, float]:
        lower, upper = float(self._model.lowerPositionLimit[0]), float(self._model.upperPositionLimit[0])
        if not lower < upper:
            raise UrdfError(
                "the hinge has no range", file=self._urdf, field=f"joint {self._section.hinge}/limit@upper", given=upper,
                allowed=f"> {lower:g} rad",
            )  # fmt: skip
        return lower, upper

    def _largest_box(self) -> tuple[Array, Array, Array]:
        """The leaf's largest box in the frame of its joint: centre (3,), edges as columns (3, 3), lengths (3,)."""
        shapes = read_boxes(self._urdf, self._section.leaf)
        boxes = [shape for shape in shapes if shape is not None]
        if not boxes:
            raise UrdfError(
                "the leaf has no box as collision shape", file=self._urdf, field=f"link {self._section.leaf}/collision",
                given=f"{len(shapes)} shapes, none a box", allowed="a <box> as wide, high and thick as the leaf",
            )  # fmt: skip
        box = max(boxes, key=lambda box: float(np.prod(box.size)))
        frame = self._model.frames[link_index(self._model, self._section.leaf, self._urdf, "door.leaf")]
        placement = frame.placement.homogeneous @ box.placement
        return placement[:3, 3], placement[:3, :3], np.asarray(box.size)

    def _vertical_axis(self) -> Array:
        """Unit vector about which the leaf turns, world frame."""
        change: Array = self.rotation(0.5) @ self.rotation(0.0).T
        axis = np.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]])
        axis /= 2.0 * math.sin(0.5)
        if abs(axis[2]) < _VERTICAL:
            raise UrdfError(
                "the hinge is not vertical", file=self._urdf, field=f"joint {self._section.hinge}",
                given=f"axis along {axis.round(4).tolist()} in the world", allowed="0 0 1 or 0 0 -1 in the world",
            )  # fmt: skip
        return axis

    def _at_a_jamb(self) -> float:
        (lower, upper), (center, edges, size) = self.limits, self._box
        reach = np.abs(edges) @ size / 2
        width, boxes = float(np.hypot(*center[:2]) + max(reach[:2])), list(self._boxes_beside())
        middle = self.origin + [0.0, 0.0, (self.rotation(0.0) @ center)[2]]

        def at_a_jamb(value: float) -> bool:
            along = self.direction(value)
            return meets(boxes, middle + width * along, along, width)

        closed, clear = closed_value((lower, upper), at_a_jamb)
        if not clear:
            raise UrdfError(
                "the leaf meets a jamb where it is not clear that the door is closed", file=self._urdf,
                field=f"joint {self._section.hinge}", given=f"{lower:g} to {upper:g} rad, a jamb along the leaf at {closed:.2f}",
                allowed="a door that is closed at π/2, at 0 or at an end of the range, or door.closed in the scenario",
            )  # fmt: skip
        return closed

    def _boxes_beside(self) -> Iterator[FixedBox]:
        """Extents along the world's axes of boxes that do not move with the leaf."""
        for placed, size in self._fixed_boxes():
            yield FixedBox(placed[:3, 3], np.abs(placed[:3, :3]) @ size / 2)

    def _fixed_boxes(self) -> Iterator[tuple[Array, Array]]:
        """Placement in the world, (4, 4), and lengths of boxes that do not move with the leaf."""
        pinocchio.framesForwardKinematics(self._model, self._data, np.zeros(1))
        for frame, placement in zip(self._model.frames, self._data.oMf, strict=True):
            if frame.type == pinocchio.FrameType.BODY and frame.parentJoint != 1:
                for box in read_boxes(self._urdf, frame.name):
                    if box is not None:
                        yield np.array(placement.homogeneous) @ box.placement, np.asarray(box.size)
