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
from doorman.kinematics.doors.urdf.beside import depth_beside, extents, fixed_boxes, height_below_lintel
from doorman.kinematics.doors.urdf.convention import closed_value, meets
from doorman.kinematics.urdf.elements import read_boxes, read_joints
from doorman.kinematics.urdf.robot import link_index
from doorman.scenario import DoorSection

Array = NDArray[np.float64]

_PARALLEL = math.cos(math.radians(0.25))
"""Least cosine between the hinge's axis and an edge of the leaf that counts as parallel to it."""
_VERTICAL = 1e-5
"""Largest horizontal component of an axis that counts as vertical: a rounded π/2 in a URDF leaves less."""
LEANS = 0.5
"""Least upward component of an axis whose end above is `up`; one that leans more has it on the right of the vehicle."""


@dataclass(frozen=True)
class LeafSize:
    """The leaf's largest box, seen from its joint."""

    sides: tuple[float, float, float, float]
    """Width from the hinge, height, thickness, and how far the face to the vehicle lies before the hinge axis [m]."""
    corner: Array
    """P_h: on the hinge's axis, at the height of the leaf's lower edge, shape (3,), world frame [m]."""


class LeafOnJoint:
    """Reader of one door.

    Args:
        urdf: Path of the URDF.
        model: Pinocchio's of it, in which the hinge alone moves.
        section: Names, and where the joint is closed if that is said.

    Raises:
        UrdfError: if the joint has no range, or the leaf has no box.
    """

    unit = "rad"
    """Of the joint's value."""

    def __init__(self, urdf: Path, model: pinocchio.Model, section: DoorSection) -> None:
        self._urdf, self._model, self._section = urdf, model, section
        self._data = model.createData()
        self.origin = np.array(model.jointPlacements[1].translation)
        """Of the joint, shape (3,), world frame [m]."""
        self.endless = read_joints(urdf)[section.hinge].kind == "continuous"
        """Whether the joint is continuous: its range is one turn about closed, and nothing stops it at the ends."""
        self._box = self._largest_box()
        self._axis = self._axis_in_world()
        self.limits = self._turn() if self.endless else self._range()
        """Of the joint [rad]."""

    @property
    def _upright(self) -> bool:
        """Whether the hinge stands rather than lies."""
        return bool(abs(self._axis[2]) >= LEANS)

    def rotation(self, value: float) -> Array:
        """Rotation of the leaf's joint frame into the world."""
        pinocchio.forwardKinematics(self._model, self._data, np.array([value]))
        return np.array(self._data.oMi[1].rotation)

    def direction(self, value: float) -> Array:
        """Unit vector along the leaf, away from the hinge and at a right angle to it."""
        center, edges, size = self._box
        rotation, axis = self.rotation(value), self._axis
        turned, way = rotation @ edges, rotation @ center
        upright = int(np.argmax(np.abs(axis @ turned)))
        if abs(axis @ turned[:, upright]) < _PARALLEL:
            raise UrdfError(
                "the leaf does not stand upright", file=self._urdf, field=f"link {self._section.leaf}/collision",
                given=f"edges along {turned.T.round(3).tolist()}",
                allowed=f"a box with edges along the hinge, {axis.round(3).tolist()}",
            )  # fmt: skip
        longest = max((i for i in range(3) if i != upright), key=lambda i: size[i])
        direction = turned[:, longest] * np.sign(turned[:, longest] @ way or 1.0)
        direction -= (axis @ direction) * axis
        return np.round(direction, 9) / np.linalg.norm(np.round(direction, 9))

    def closed(self) -> tuple[float, float]:
        """Joint value of the closed door [rad or m], and 1 where it grows as the door opens, else −1."""
        lower, upper = self.limits
        closed = self._section.closed
        if closed is None:
            closed = self._likely_closed()
        elif not lower - 1e-3 <= closed <= upper + 1e-3:
            raise UrdfError(
                "the door is closed outside the joint's range", file=self._urdf, field="door.closed", given=closed,
                allowed=f"{lower:g} to {upper:g} {self.unit}",
            )  # fmt: skip
        return closed, 1.0 if self.endless or upper - closed > closed - lower else -1.0

    def directions(self, closed: float, sense: float) -> tuple[Array, Array]:
        """Direction along the closed leaf from hinge to latch, and the one in which the leaf moves as it opens."""
        along = self.direction(closed)
        return along, sense * np.cross(self._axis, along)

    def up(self, into: Array, along: Array) -> Array:
        """Unit vector along the hinge's axis: upwards, or to the right of a vehicle that looks into the doorway."""
        right = float(into[1] * self._axis[0] - into[0] * self._axis[1])
        return np.asarray(self._axis * np.sign(self._axis[2] if abs(self._axis[2]) >= LEANS else right))

    def center_of_mass(self, value: float) -> Array:
        """Centre of mass of what the joint carries."""
        pinocchio.forwardKinematics(self._model, self._data, np.array([value]))
        return np.array(self._data.oMi[1].act(self._model.inertias[1].lever))

    def mass_and_inertia(self) -> tuple[float, float]:
        """Mass of what the joint carries, and its inertia about the joint's axis [kg], [kg m²]."""
        mass, along_joint = float(self._model.inertias[1].mass), self._inertia_along_the_joint()
        for name, value, unit in (("mass", mass, "kg"), ("inertia", along_joint, "kg m² about the hinge")):
            if not value > 0.0:
                raise UrdfError(
                    f"the leaf has no {name}", file=self._urdf, field=f"link {self._section.leaf}/inertial/{name}",
                    given=value, allowed=f"> 0 {unit}",
                )  # fmt: skip
        return mass, along_joint

    def size(self, axes: Array, closed: float) -> LeafSize:
        """Size of the leaf."""
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
        return LeafSize(sides, self.origin + (middle[2] - reach[2]) * axes[2])

    def fixed_boxes(self) -> Iterator[tuple[Array, Array]]:
        """Placement in the world, (4, 4), and lengths of boxes that do not move with the leaf."""
        return fixed_boxes(self._urdf, self._model)

    def frame_depth(self, axes: Array, leaf: LeafSize) -> tuple[float, float]:
        """How far boxes beside the doorway, that do not move with the leaf, reach before and behind the hinge axis [m]."""
        return depth_beside(self.fixed_boxes(), axes, leaf.corner, leaf.sides[:2], self._upright)

    def frame_height(self, axes: Array, leaf: LeafSize) -> float | None:
        """Height of the opening above the leaf's lower edge; None where nothing of the frame is over it [m]."""
        return height_below_lintel(self.fixed_boxes(), axes, leaf.corner, leaf.sides[:2]) if self._upright else None

    def frame(self, name: str, value: float) -> tuple[Array, Array]:
        """Origin and x axis of a frame on the leaf."""
        index = link_index(self._model, name, self._urdf, "contact.frame")
        if self._model.frames[index].parentJoint != 1:
            raise UrdfError(
                "the contact frame does not move with the leaf", file=self._urdf, field="contact.frame", given=name,
                allowed=f"a link that joint '{self._section.hinge}' moves",
            )  # fmt: skip
        pinocchio.framesForwardKinematics(self._model, self._data, np.array([value]))
        placement = self._data.oMf[index]
        return np.array(placement.translation), np.array(placement.rotation[:, 0])

    def _turn(self) -> tuple[float, float]:
        """Range of a continuous joint: half a turn either way from closed, which is 0 where no jamb tells."""
        closed = self._section.closed
        closed = self._at_a_jamb((0.0, 2.0 * math.pi), False) if closed is None else closed
        return closed - math.pi, closed + math.pi

    def _range(self) -> tuple[float, float]:
        lower, upper = float(self._model.lowerPositionLimit[0]), float(self._model.upperPositionLimit[0])
        if not lower < upper:
            raise UrdfError(
                "the hinge has no range", file=self._urdf, field=f"joint {self._section.hinge}/limit@upper", given=upper,
                allowed=f"> {lower:g} {self.unit}",
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

    def _axis_in_world(self) -> Array:
        """Unit vector about which the leaf turns, world frame; plainly vertical where it is nearly so."""
        change: Array = self.rotation(0.5) @ self.rotation(0.0).T
        axis = np.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]])
        axis /= 2.0 * math.sin(0.5)
        return np.array([0.0, 0.0, np.sign(axis[2])]) if np.hypot(*axis[:2]) < _VERTICAL else axis

    def _inertia_along_the_joint(self) -> float:
        """About its axis [kg m²]."""
        axis = self.rotation(0.0).T @ self._axis
        return float(axis @ self._model.inertias[1].matrix()[3:, 3:] @ axis)

    def _likely_closed(self) -> float:
        """Joint value at which the door is closed, where the scenario does not say [rad]."""
        return 0.5 * sum(self.limits) if self.endless else self._at_a_jamb(self.limits, self._upright)

    def _at_a_jamb(self, limits: tuple[float, float], upright: bool) -> float:
        (lower, upper), (center, edges, size) = limits, self._box
        reach = np.abs(edges) @ size / 2
        across = [i for i in range(3) if i != int(np.argmax(np.abs(self.rotation(0.0).T @ self._axis)))]
        width, boxes = float(np.hypot(*center[across]) + max(reach[across])), extents(self.fixed_boxes())
        middle = self.origin + (self._axis @ self.rotation(0.0) @ center) * self._axis

        def at_a_jamb(value: float) -> bool:
            along = self.direction(value)
            return meets(boxes, middle + width * along, along, width)

        closed, clear = closed_value(limits, at_a_jamb, upright)
        if not clear:
            raise UrdfError(
                "the leaf meets a jamb at an angle that need not be the closed one", file=self._urdf,
                field=f"joint {self._section.hinge}", given=f"{lower:g} to {upper:g} rad, a jamb along the leaf at {closed:.2f}",
                allowed="a door that is closed at π/2, at 0 or at an end of the range, or door.closed in the scenario",
            )  # fmt: skip
        return closed
