"""What a door's URDF says of the leaf on its joint: which way it turns and points, where it is closed, what stands beside it."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.doors.urdf.beside import boxes_along, depth_beside, fixed_boxes, height_below_lintel
from doorman.kinematics.doors.urdf.convention import ROUNDED, Closed, closed_value, meets
from doorman.kinematics.doors.urdf.leaf_shape import LeafShape, read_shape
from doorman.kinematics.urdf.elements import read_joints
from doorman.kinematics.urdf.robot import link_index
from doorman.scenario import ContactSection, DoorSection

_VERTICAL = 1e-5
"""Largest horizontal component of an axis that counts as vertical: a rounded π/2 in a URDF leaves less."""
LEANS = 0.5
"""Least upward component of an axis whose end above is `up`; one that leans more has it on the right of the vehicle."""
UP = np.eye(3)[2]


class LeafSize(NamedTuple):
    """The leaf, seen from its joint."""

    sides: tuple[float, float, float, float]
    """Width from the hinge, height, thickness, and how far the face to the vehicle lies before the hinge axis [m]."""
    corner: Array
    """P_h: on the hinge's axis, at the height of the leaf's lower edge, shape (3,), world frame [m]."""


class LeafOnJoint:
    """Reader of one door, by Pinocchio's model in which the hinge alone moves; `turns` is the sense of α as the door opens."""

    unit = "rad"
    """Unit of the joint's value."""

    def __init__(
        self, urdf: Path, model: pinocchio.Model, section: DoorSection, contact: ContactSection | None, turns: float
    ) -> None:
        self._urdf, self._model, self._section, self._turns = urdf, model, section, turns
        self.named = contact if contact is not None and contact.named is not None else None
        """The contact, if it names a place of the URDF."""
        self._data = model.createData()
        self.origin = np.array(model.jointPlacements[1].translation)
        """Origin of the joint, shape (3,), world frame [m]."""
        self.endless = read_joints(urdf)[section.hinge].kind == "continuous"
        """Whether the joint is continuous: its range is one turn about closed, and nothing stops it at the ends."""
        self.axis = self._axis_in_world()
        """Unit vector of hinge or slide, shape (3,), world frame."""
        self.shape = read_shape(urdf, model, self.rotation(0.0).T @ self.axis, section.leaf)
        """All that the joint carries."""

    @cached_property
    def limits(self) -> tuple[float, float]:
        """Least and largest value of the joint [rad]."""
        return self._turn() if self.endless else self._range()

    @cached_property
    def closed(self) -> Closed:
        """Where the joint is closed."""
        lower, upper = self.limits
        value = self._section.closed
        if value is None:
            return self._likely_closed()
        if not lower - ROUNDED <= value <= upper + ROUNDED:
            raise UrdfError(
                "the door is closed outside the joint's range", file=self._urdf, field="door.closed", given=value,
                allowed=f"{lower:g} to {upper:g} {self.unit}",
            )  # fmt: skip
        return Closed(value)

    @cached_property
    def sense(self) -> float:
        """1 where the joint's value grows as the door opens, else −1."""
        (lower, upper), closed = self.limits, self.closed.value
        return 1.0 if self.endless or upper - closed > closed - lower else -1.0

    @cached_property
    def axes(self) -> Array:
        """Rows `into`, `along` and `up` of the doorway, world frame, shape (3, 3)."""
        along, opens = self._directions()
        into = -self._turns * opens
        return np.vstack([into, along, self._up(into, along)])

    @cached_property
    def axes_in_leaf(self) -> Array:
        """The same in the axes of the link that the joint carries, where the door is closed."""
        return np.asarray(self.axes @ self.rotation(self.closed.value))

    @property
    def _upright(self) -> bool:
        """Whether the hinge stands rather than lies."""
        return bool(abs(self.axis[2]) >= LEANS)

    def rotation(self, value: float) -> Array:
        """Rotation of the leaf's joint frame into the world."""
        return np.array(self._at(value).rotation)

    def _at(self, value: float) -> pinocchio.SE3:
        pinocchio.forwardKinematics(self._model, self._data, np.array([value]))
        return self._data.oMi[1]

    def _direction(self, value: float) -> Array:
        """Unit vector along the leaf, away from the hinge and at a right angle to it."""
        along = self.shape.along
        if along is None:
            raise UrdfError(
                "the leaf does not stand upright", file=self._urdf, field=f"link {self._section.leaf}/collision",
                given="no shape with edges along the hinge and across it",
                allowed=f"a leaf with edges along the hinge, {self.axis.round(3).tolist()}",
            )  # fmt: skip
        return self._across(self.rotation(value) @ along)

    def _across(self, direction: Array) -> Array:
        """Unit vector along the part of a direction that is at a right angle to the axis."""
        across = np.round(direction - (self.axis @ direction) * self.axis, 9)
        return np.asarray(across / np.linalg.norm(across))

    def _directions(self) -> tuple[Array, Array]:
        """Direction along the closed leaf from hinge to latch, and the one in which the leaf moves as it opens."""
        along = self._direction(self.closed.value)
        return along, self.sense * np.cross(self.axis, along)

    def _up(self, into: Array, along: Array) -> Array:
        """Unit vector along the hinge's axis: upwards, or to the right of a vehicle that looks into the doorway."""
        right = float(into[1] * self.axis[0] - into[0] * self.axis[1])
        return np.asarray(self.axis * np.sign(self.axis[2] if self._upright else right))

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass of what the joint carries, where the door is closed."""
        return np.array(self._at(self.closed.value).act(self._model.inertias[1].lever))

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

    @cached_property
    def size(self) -> LeafSize:
        """Size of the leaf."""
        into, along, up = self.axes_in_leaf
        (_, width), (lowest, highest) = self.shape.extent(along), self.shape.extent(up)
        front, back = self.shape.extent(into)
        if width <= 0.0 or back - front > width - self.shape.extent(along)[0]:
            raise UrdfError(
                "the leaf turns in the plane of its face, or does not reach away from its hinge", file=self._urdf,
                field=f"link {self._section.leaf}/collision",
                given=f"{back - front:.3f} m across, {self.shape.width(along):.3f} m along, {highest - lowest:.3f} m up",
                allowed="a leaf that is longer than thick and lies beside the hinge",
            )  # fmt: skip
        sides = float(width), float(highest - lowest), float(back - front), 0.0 - front
        return LeafSize(sides, self.origin + lowest * self.axes[2])

    def face_offset(self, place: tuple[float, float]) -> float:
        """How far the face to the vehicle lies before the hinge axis, along and up from P_h, on the panel there [m]."""
        into, along, up = self.axes_in_leaf
        return 0.0 - self.shape.face(into, along, up, (place[0], self.shape.extent(up)[0] + place[1]))

    @cached_property
    def fixed_boxes(self) -> tuple[tuple[Array, Array], ...]:
        """Placement in the world, (4, 4), and lengths of boxes that do not move with the leaf."""
        return tuple(fixed_boxes(self._urdf, self._model))

    def frame_depth(self) -> tuple[float, float]:
        """How far boxes beside the doorway, that do not move with the leaf, reach before and behind the hinge axis [m]."""
        boxes = boxes_along(self.fixed_boxes, self.axes, self.size.corner)
        return depth_beside(boxes, self.size.sides[:2], self._upright)

    def frame_height(self) -> float | None:
        """Height of the opening above the leaf's lower edge; None where nothing of the frame is over it [m]."""
        boxes = boxes_along(self.fixed_boxes, self.axes, self.size.corner) if self._upright else []
        return height_below_lintel(boxes, self.size.sides[:2])

    def beside(self, point: Array) -> tuple[Array, float] | None:
        """Plane beside the way of a contact point, which the vehicle stays before; a hinged leaf has none."""
        return None

    def _planes_behind(self, normal: Array, point: Array) -> list[float]:
        """How far boxes that stand still reach along a normal in the world, of those that a point is beyond [m]."""
        reaches = (
            float(normal @ placed[:3, 3] + np.abs(normal @ placed[:3, :3]) @ size / 2)
            for placed, size in self.fixed_boxes
        )
        return [reach for reach in reaches if reach < float(normal @ point)]

    def contact(self, value: float, into: Array) -> tuple[Array, Array | None]:
        """Where a tip touches, as the section names it, and the unit vector away from the leaf there, if it names one."""
        contact = self.named
        assert contact is not None
        if contact.link is not None:
            return self._on_link(contact.link, value, into)
        name = self._section.leaf if contact.frame is None else contact.frame
        placement = self._placement(name, "door.leaf" if contact.frame is None else "contact.frame", value)
        if contact.point is None:
            return placement[:3, 3], placement[:3, 0]
        normal = None if contact.normal is None else placement[:3, :3] @ contact.normal / np.linalg.norm(contact.normal)
        return placement[:3, :3] @ contact.point + placement[:3, 3], normal

    def _on_link(self, name: str, value: float, into: Array) -> tuple[Array, Array]:
        """Middle of the outer side of what a link has on one side of the leaf."""
        self._placement(name, "contact.link", value)
        rotation, parts = self.rotation(value), [part for part in self.shape.parts if part.link == name]
        if not parts:
            raise UrdfError(
                "the contact's link has no collision shape", file=self._urdf, field="contact.link", given=name,
                allowed="a link with a shape on the leaf, or contact.point",
            )  # fmt: skip
        handle = LeafShape(tuple(parts), self.shape.axis)
        (front, back), ends = self.shape.extent(rotation.T @ into), handle.extent(rotation.T @ into)
        outward = -into if front - ends[0] >= ends[1] - back else into
        across = np.cross(self.axis if not self.unit == "m" else UP, outward)
        axes = np.array([outward, across, np.cross(outward, across)])
        reaches = np.array([handle.extent(rotation.T @ axis) for axis in axes])
        at = np.array([reaches[0, 1], *reaches[1:].mean(axis=1)])
        return np.array(self._data.oMi[1].translation) + axes.T @ at, outward

    def _placement(self, name: str, field: str, value: float) -> Array:
        """Placement of a link of the leaf in the world, homogeneous, shape (4, 4)."""
        index = link_index(self._model, name, self._urdf, field)
        if self._model.frames[index].parentJoint != 1:
            raise UrdfError(
                "the contact does not move with the leaf", file=self._urdf, field=field, given=name,
                allowed=f"a link that joint '{self._section.hinge}' moves",
            )  # fmt: skip
        pinocchio.framesForwardKinematics(self._model, self._data, np.array([value]))
        return np.array(self._data.oMf[index].homogeneous)

    def _turn(self) -> tuple[float, float]:
        """Range of a continuous joint: half a turn either way from closed, which is 0 where no jamb tells."""
        closed = self._section.closed
        closed = self._at_a_jamb((0.0, 2.0 * math.pi), False).value if closed is None else closed
        return closed - math.pi, closed + math.pi

    def _range(self) -> tuple[float, float]:
        lower, upper = float(self._model.lowerPositionLimit[0]), float(self._model.upperPositionLimit[0])
        if not lower < upper:
            raise UrdfError(
                "the hinge has no range", file=self._urdf, field=f"joint {self._section.hinge}/limit@upper", given=upper,
                allowed=f"> {lower:g} {self.unit}",
            )  # fmt: skip
        return lower, upper

    def _axis_in_world(self) -> Array:
        """Unit vector about which the leaf turns, world frame; plainly vertical where it is nearly so."""
        change: Array = self.rotation(0.5) @ self.rotation(0.0).T
        axis = np.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]])
        axis /= 2.0 * math.sin(0.5)
        return np.sign(axis[2]) * UP if np.hypot(*axis[:2]) < _VERTICAL else axis

    def _inertia_along_the_joint(self) -> float:
        """About its axis [kg m²]."""
        axis = self.rotation(0.0).T @ self.axis
        return float(axis @ self._model.inertias[1].matrix()[3:, 3:] @ axis)

    def _likely_closed(self) -> Closed:
        """Where the door is closed, if the scenario does not say [rad]."""
        if self.endless:
            return Closed(0.5 * sum(self.limits), self._at_a_jamb((0.0, 2.0 * math.pi), False).guessed)
        return self._at_a_jamb(self.limits, self._upright)

    def _at_a_jamb(self, limits: tuple[float, float], upright: bool) -> Closed:
        lower, upper = limits
        axis, boxes = self.rotation(0.0).T @ self.axis, boxes_along(self.fixed_boxes, np.eye(3), np.zeros(3))
        middle = self.origin + 0.5 * sum(self.shape.extent(axis)) * self.axis

        def at_a_jamb(value: float) -> bool:
            along = self._direction(value)
            width = self.shape.extent(self.rotation(value).T @ along)[1]
            return meets(boxes, middle + width * along, along, width)

        closed = closed_value(limits, at_a_jamb, upright)
        if closed.doubtful:
            raise UrdfError(
                "the leaf meets a jamb at an angle that need not be the closed one", file=self._urdf,
                field=f"joint {self._section.hinge}", given=f"{lower:g} to {upper:g} rad, a jamb at {closed.value:.2f}",
                allowed="a door that is closed at π/2, at 0 or at an end of the range, or door.closed in the scenario",
            )  # fmt: skip
        return closed
