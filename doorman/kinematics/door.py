"""Door: hinge line, leaf and the torques in the hinge, all from its URDF and the scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.copying import PerThread
from doorman.exceptions import UrdfError
from doorman.kinematics.door_convention import STEPS, FixedBox, closed_value, meets, standing_joints
from doorman.kinematics.door_variant import write_door_variant
from doorman.kinematics.urdf import frozen, link_index, load_pinocchio
from doorman.kinematics.urdf_elements import read_boxes, read_joints
from doorman.scenario import DoorSection

Array = NDArray[np.float64]


_VERTICAL = math.cos(math.radians(0.25))
"""Least upward component of an axis or an edge that counts as vertical: gravity turns a leaf that leans so by little."""


class Door:
    r"""Door on a vertical hinge, of either hand, anywhere in the world. Threads may share it.

    Its angle α is π/2 where it is closed and falls as it opens, whatever the URDF's joint says there. With the horizontal unit
    vectors `into` (the way that the closed leaf swings) and `along` (from hinge to latch along the closed leaf), leaf and normal
    are

    .. math:: c = \cos\alpha\,i + \sin\alpha\,a, \qquad n_D = \sin\alpha\,i - \cos\alpha\,a .

    The vehicle is on the side from which the door is pushed open, and n_D points away from it.

    Args:
        urdf: Path of the URDF; `self.urdf` is another file where the section changes the leaf.
        section: Names of leaf and hinge, where the joint is closed, the torques in the hinge, and the leaf's width and mass if
            other than the URDF's.

    Raises:
        UrdfError: if the leaf or the hinge is missing, the hinge's axis is not vertical, the leaf has no mass or no box, or
            something on the leaf moves.
    """

    placement: Array = frozen(np.eye(4))
    """Of the whole door in the world against where its URDF has it, homogeneous, shape (4, 4)."""
    yaw: float = 0.0
    """By which that turns it about the vertical [rad]."""

    def __init__(self, urdf: Path, section: DoorSection | None = None) -> None:
        self.section = section or DoorSection()
        if self.section.width is not None or self.section.mass is not None:
            urdf = _variant(urdf, self.section)
        self.urdf = urdf
        full = load_pinocchio(urdf)
        leaf = link_index(full, self.section.leaf, urdf, "door.leaf")
        self._hinge = self._hinge_joint(full)
        self.standing_joints = standing_joints(urdf, full, self._hinge)
        """Joints that could move, and neither carry the leaf nor hang on it; they stand at zero."""
        locked = [i for i in range(1, full.njoints) if i != self._hinge]
        self.model = pinocchio.buildReducedModel(full, locked, pinocchio.neutral(full)) if locked else full
        self._own: PerThread[pinocchio.Data] = PerThread()
        if full.frames[leaf].parentJoint != self._hinge:
            raise UrdfError(
                "the leaf does not hang on the hinge", file=urdf, field="door.leaf", given=self.section.leaf,
                allowed=f"a link moved by joint '{self.section.hinge}'",
            )  # fmt: skip
        self.hinge_position = frozen(self.model.jointPlacements[1].translation)
        """P_h, on the hinge's axis at the height of the leaf's lower edge, shape (3,), world frame [m]."""
        self._box = self._largest_box()
        lower, upper = self._range()
        self.closed, self._sense = self._closed_value(lower, upper)
        """Value of the URDF's joint where the door is closed [rad]."""
        self.along, self.into = self._directions()
        self.hand = float(np.sign(np.cross(self.into, self.along)[2]))
        """1 where the hinge is on the right of somebody who looks along `into`, else −1."""
        self.azimuth = math.atan2(self.into[1], self.into[0])
        """Of `into`, about z from the world's x axis [rad]."""
        self.lower_limit, self.upper_limit = sorted(self.angle_of_joint(end) for end in (lower, upper))
        """Of α [rad]."""
        self.mass = float(self.model.inertias[1].mass)
        self.inertia = self._inertia_about_hinge()
        self.width, self.height, self.thickness, self.surface_offset = self._leaf_size()
        """`surface_offset`: o, how far the leaf's face to the vehicle lies before the hinge axis [m]."""
        self.frame_depth = self._frame_depth()
        """How far the jambs' boxes reach before the hinge axis, towards the vehicle [m]."""
        hinge = read_joints(urdf)[self.section.hinge]
        self.damping = float(hinge.damping if self.section.damping is None else self.section.damping)
        self.friction = float(hinge.friction if self.section.friction is None else self.section.friction)
        self.stiffness = self.section.stiffness
        self.rest_angle = self.section.rest_angle
        self.friction_rate = self.section.friction_rate

    def leaf_direction(self, door_angle: float) -> Array:
        """Horizontal unit vector along the leaf from hinge to latch, world frame."""
        return np.asarray(math.cos(door_angle) * self.into + math.sin(door_angle) * self.along)

    def normal(self, door_angle: float) -> Array:
        """Unit normal n_D of the leaf that points away from the vehicle, world frame; a growing α moves the leaf against it."""
        return np.asarray(math.sin(door_angle) * self.into - math.cos(door_angle) * self.along)

    def heading(self, door_angle: float) -> float:
        """Yaw of a vehicle that looks along the leaf's normal [rad]."""
        return self.azimuth + self.hand * (door_angle - 0.5 * math.pi)

    def angle_of(self, offset: Array) -> float:
        """α at which a point of the leaf's surface has a horizontal offset from the hinge, (at least 2,), world frame [rad]."""
        along, into = float(offset[:2] @ self.along[:2]), float(offset[:2] @ self.into[:2])
        way = math.hypot(along, into)
        before = math.asin(min(max(self.surface_offset / way, -1.0), 1.0)) if way > 0.0 else 0.0
        return math.atan2(along, into) - before

    def in_doorway(self, vector: Array) -> Array:
        """A vector's components along `into`, along the closed leaf, and up, (…, 3) from (…, 3) in the world frame."""
        return np.asarray(vector @ self.axes.T)

    def from_doorway(self, components: Array) -> Array:
        """The inverse of `in_doorway`."""
        return np.asarray(components @ self.axes)

    def leaf_rotation(self, door_angle: float) -> Array:
        """Frame of the leaf's joint to the world at α, (3, 3)."""
        return self._joint_turned(self.joint_value(door_angle))

    def joint_value(self, door_angle: float) -> float:
        """Value of the URDF's joint at α [rad]."""
        return self.closed + self._sense * (0.5 * math.pi - float(door_angle))

    def joint_rate(self, door_rate: float) -> float:
        """Rate of the URDF's joint [rad/s]."""
        return -self._sense * door_rate

    def angle_of_joint(self, value: float) -> float:
        """α at a value of the URDF's joint [rad]."""
        return 0.5 * math.pi - self._sense * (float(value) - self.closed)

    def link_placements(self, door_angle: float) -> dict[str, Array]:
        """Placement of every link in the world.

        Args:
            door_angle: α [rad].

        Returns:
            Homogeneous matrices of shape (4, 4) by link name.
        """
        data = self._own.get(self.model.createData)
        pinocchio.framesForwardKinematics(self.model, data, np.array([self.joint_value(door_angle)]))
        return {
            frame.name: np.array(placement.homogeneous)
            for frame, placement in zip(self.model.frames, data.oMf, strict=True)
            if frame.type == pinocchio.FrameType.BODY
        }

    def contact_point(self, door_angle: float, distance_from_hinge: float, height: float) -> Array:
        r"""Point of the leaf's surface, :math:`P_h + D_V c(\alpha) - o\,n_D(\alpha) + D_H e_3`.

        Args:
            door_angle: α [rad].
            distance_from_hinge: D_V [m].
            height: D_H above the lower end of the hinge line [m].

        Returns:
            Shape (3,), world frame [m].
        """
        beside = distance_from_hinge * self.leaf_direction(door_angle) - self.surface_offset * self.normal(door_angle)
        return np.asarray(self.hinge_position + beside + np.array([0.0, 0.0, height]))

    def lever(self, door_angle: float, distance_from_hinge: float) -> Array:
        r"""How α moves that point, :math:`J = -D_V n_D - o\,c`, shape (3,), world frame [m]."""
        moved = distance_from_hinge * self.normal(door_angle) + self.surface_offset * self.leaf_direction(door_angle)
        return np.asarray(-moved)

    def onto_face(self, point: Array, door_angle: float) -> Array:
        r"""A point moved along the leaf's normal onto its face to the vehicle, :math:`q + (n_D^T(P_h - q) - o)\,n_D`.

        Args:
            point: q, shape (3,), world frame [m].
            door_angle: α [rad]; o is the `surface_offset`.

        Returns:
            Shape (3,), world frame [m].
        """
        normal = self.normal(door_angle)
        return np.asarray(point + (normal @ (self.hinge_position - point) - self.surface_offset) * normal)

    def hinge_torque(self, door_angle: float, door_rate: float) -> float:
        r"""Torque against the motion, :math:`b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0)`.

        Args:
            door_angle: α [rad].
            door_rate: α̇ [rad/s].

        Returns:
            [N m]; α̈ = −torque/I_D when nothing else acts.
        """
        friction = self.friction * np.tanh(door_rate / self.friction_rate)
        return float(self.damping * door_rate + friction + self.stiffness * (door_angle - self.rest_angle))

    def _hinge_joint(self, full: pinocchio.Model) -> int:
        name = self.section.hinge
        if not full.existJointName(name):
            joints = ", ".join(list(full.names)[1:]) or "none that moves"
            raise UrdfError(
                f"the URDF has no moving joint '{name}'", file=self.urdf, field="door.hinge", given=name, allowed=joints
            )
        index = int(full.getJointId(name))
        if full.joints[index].nq != 1 or not full.joints[index].shortname().startswith("JointModelR"):
            raise UrdfError(
                "the hinge is not a revolute joint", file=self.urdf, field=f"joint {name}",
                given=full.joints[index].shortname().removeprefix("JointModel"), allowed="revolute",
            )  # fmt: skip
        return index

    def _largest_box(self) -> tuple[Array, Array, Array]:
        """The leaf's largest box in the frame of its joint: centre (3,), edges as columns (3, 3), lengths (3,)."""
        shapes = read_boxes(self.urdf, self.section.leaf)
        boxes = [shape for shape in shapes if shape is not None]
        if not boxes:
            raise UrdfError(
                "the leaf has no box as collision shape", file=self.urdf, field=f"link {self.section.leaf}/collision",
                given=f"{len(shapes)} shapes, none a box", allowed="a <box> as wide, high and thick as the leaf",
            )  # fmt: skip
        box = max(boxes, key=lambda box: float(np.prod(box.size)))
        frame = self.model.frames[link_index(self.model, self.section.leaf, self.urdf, "door.leaf")]
        placement = frame.placement.homogeneous @ box.placement
        return placement[:3, 3], placement[:3, :3], np.asarray(box.size)

    def _joint_turned(self, value: float) -> Array:
        """Rotation of the leaf's joint frame into the world at a joint value, (3, 3)."""
        data = self._own.get(self.model.createData)
        pinocchio.forwardKinematics(self.model, data, np.array([value]))
        return np.array(data.oMi[1].rotation)

    def _axis(self) -> Array:
        """Unit vector about which the leaf turns, world frame."""
        change: Array = self._joint_turned(0.5) @ self._joint_turned(0.0).T
        axis = np.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]])
        axis /= 2.0 * math.sin(0.5)
        if abs(axis[2]) < _VERTICAL:
            raise UrdfError(
                "the hinge is not vertical", file=self.urdf, field=f"joint {self.section.hinge}",
                given=f"axis along {axis.round(4).tolist()} in the world", allowed="0 0 1 or 0 0 -1 in the world",
            )  # fmt: skip
        return axis

    def _leaf_at(self, value: float) -> Array:
        """Horizontal unit vector along the leaf, away from the hinge, at a joint value."""
        center, edges, size = self._box
        rotation = self._joint_turned(value)
        turned, way = rotation @ edges, rotation @ center
        upright = int(np.argmax(np.abs(turned[2])))
        if abs(turned[2, upright]) < _VERTICAL:
            raise UrdfError(
                "the leaf does not stand upright", file=self.urdf, field=f"link {self.section.leaf}/collision",
                given=f"edges along {turned.T.round(3).tolist()}", allowed="a box with vertical edges",
            )  # fmt: skip
        longest = max((i for i in range(3) if i != upright), key=lambda i: size[i])
        direction = turned[:, longest] * np.sign(turned[:, longest] @ way or 1.0) * [1.0, 1.0, 0.0]
        return np.round(direction, 9) / np.linalg.norm(np.round(direction, 9))

    def _closed_value(self, lower: float, upper: float) -> tuple[float, float]:
        """Joint value of the closed door, and 1 where it grows as the door opens, else −1."""
        self._axis()
        closed = self.section.closed
        if closed is None:
            closed = self._found_closed(lower, upper)
        elif not lower - 1e-3 <= closed <= upper + 1e-3:
            raise UrdfError(
                "closed outside the hinge's range", file=self.urdf, field="door.closed", given=closed,
                allowed=f"{lower:g} to {upper:g} rad",
            )  # fmt: skip
        return closed, 1.0 if upper - closed > closed - lower else -1.0

    def _found_closed(self, lower: float, upper: float) -> float:
        center, edges, size = self._box
        reach = np.abs(edges) @ size / 2
        width, boxes = float(np.hypot(*center[:2]) + max(reach[:2])), list(self._boxes_beside())
        middle = self.hinge_position + [0.0, 0.0, (self._joint_turned(0.0) @ center)[2]]

        def at_a_jamb(value: float) -> bool:
            return meets(boxes, middle + width * self._leaf_at(value), self._leaf_at(value), width)

        closed = closed_value((lower, upper), at_a_jamb)
        if closed is None:
            closed = next(float(value) for value in np.linspace(lower, upper, STEPS + 1) if at_a_jamb(float(value)))
            raise UrdfError(
                "the leaf meets a jamb where it is not clear that the door is closed", file=self.urdf,
                field=f"joint {self.section.hinge}", given=f"{lower:g} to {upper:g} rad, a jamb along the leaf at {closed:.2f}",
                allowed="a door that is closed at π/2, at 0 or at an end of the range, or door.closed in the scenario",
            )  # fmt: skip
        return closed

    def _directions(self) -> tuple[Array, Array]:
        """Along the closed leaf from hinge to latch, and the horizontal way that it swings as it opens."""
        along = self._leaf_at(self.closed)
        into = self._sense * np.sign(self._axis()[2]) * np.array([-along[1], along[0], 0.0])
        return frozen(along), frozen(into)

    @property
    def axes(self) -> Array:
        """Rows `into`, `along` and up, (3, 3): from the world to the doorway; its determinant is the door's `hand`."""
        return np.vstack([self.into, self.along, [0.0, 0.0, 1.0]])

    def _range(self) -> tuple[float, float]:
        lower, upper = float(self.model.lowerPositionLimit[0]), float(self.model.upperPositionLimit[0])
        if not lower < upper:
            raise UrdfError(
                "the hinge has no range", file=self.urdf, field=f"joint {self.section.hinge}/limit@upper", given=upper,
                allowed=f"> {lower:g} rad",
            )  # fmt: skip
        return lower, upper

    def _inertia_about_hinge(self) -> float:
        inertia = self.model.inertias[1]
        about_hinge = float(inertia.matrix()[5, 5])
        for name, value, unit in (("mass", self.mass, "kg"), ("inertia", about_hinge, "kg m² about the hinge")):
            if not value > 0.0:
                raise UrdfError(
                    f"the leaf has no {name}",
                    file=self.urdf,
                    field=f"link {self.section.leaf}/inertial/{name}",
                    given=value,
                    allowed=f"> 0 {unit}",
                )
        return about_hinge

    def _leaf_size(self) -> tuple[float, float, float, float]:
        """Width from the hinge, height and thickness of the leaf's largest box, and y of its face to the vehicle."""
        center, edges, size = self._box
        turned = self.axes @ self._joint_turned(self.closed)
        middle, reach = turned @ center, np.abs(turned @ edges) @ size / 2
        if middle[1] <= 0.0 or reach[0] > reach[1]:
            raise UrdfError(
                "the leaf does not reach away from its hinge", file=self.urdf, field=f"link {self.section.leaf}/collision",
                given=f"a box of {np.round(2 * reach, 4).tolist()} m around {middle.round(4).tolist()} m, across, along, up",
                allowed="a leaf that is longer than thick and lies beside the hinge",
            )  # fmt: skip
        self.hinge_position = frozen(self.hinge_position + [0.0, 0.0, middle[2] - reach[2]])
        return float(middle[1] + reach[1]), float(2 * reach[2]), float(2 * reach[0]), float(reach[0] - middle[0])

    def _frame_depth(self) -> float:
        """Of the boxes beside the doorway that do not move with the leaf; 0 if there are none."""
        middle, nearest = 0.5 * self.width, [0.0]
        for placed, size in self._fixed_boxes():
            center = self.axes @ (placed[:3, 3] - self.hinge_position)
            half = np.abs(self.axes @ placed[:3, :3]) @ size / 2
            if abs(center[1] - middle) > half[1]:
                nearest.append(float(center[0] - half[0]))
        return -min(nearest)

    def _boxes_beside(self) -> Iterator[FixedBox]:
        """Extents along the world's axes of boxes that do not move with the leaf."""
        for placed, size in self._fixed_boxes():
            yield FixedBox(placed[:3, 3], np.abs(placed[:3, :3]) @ size / 2)

    def _fixed_boxes(self) -> Iterator[tuple[Array, Array]]:
        """Placement in the world, (4, 4), and lengths of boxes that do not move with the leaf."""
        data = self._own.get(self.model.createData)
        pinocchio.framesForwardKinematics(self.model, data, np.zeros(1))
        for frame, placement in zip(self.model.frames, data.oMf, strict=True):
            if frame.type == pinocchio.FrameType.BODY and frame.parentJoint != 1:
                for box in read_boxes(self.urdf, frame.name):
                    if box is not None:
                        yield np.array(placement.homogeneous) @ box.placement, np.asarray(box.size)


def _variant(urdf: Path, section: DoorSection) -> Path:
    """URDF of the door with the section's width and mass of the leaf."""
    written = Door(urdf, section.model_copy(update={"width": None, "mass": None}))
    turned = written.leaf_rotation(0.5 * math.pi)
    return write_door_variant(
        urdf, section.leaf, written.hinge_position, turned.T @ written.along, written.along, written.width,
        section.width, section.mass,
    )  # fmt: skip
