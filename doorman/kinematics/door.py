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
from doorman.kinematics.door_convention import FixedBox, closed_at_zero, standing_joints
from doorman.kinematics.door_variant import write_door_variant
from doorman.kinematics.urdf import frozen, link_index, load_pinocchio
from doorman.kinematics.urdf_elements import read_boxes, read_joints
from doorman.scenario import DoorSection

Array = NDArray[np.float64]


def leaf_direction(door_angle: float) -> Array:
    """Unit vector along the leaf from hinge to latch, [cos α, sin α, 0], world frame."""
    return np.array([math.cos(door_angle), math.sin(door_angle), 0.0])


def door_normal(door_angle: float) -> Array:
    """Unit normal of the leaf that points away from the vehicle, n_D = [sin α, −cos α, 0], world frame."""
    return np.array([math.sin(door_angle), -math.cos(door_angle), 0.0])


class Door:
    """Hinged door. Threads may share it.

    Args:
        urdf: Path of the URDF; `self.urdf` is another file where the section changes the leaf.
        section: Names of leaf and hinge, the torques in the hinge, and the leaf's width and mass if other than the URDF's.

    Raises:
        UrdfError: if the leaf or the hinge is missing, the hinge's axis is not +z, the leaf has no mass or no box, something
            on the leaf moves, or the door is closed at 0.
    """

    placement: Array = frozen(np.eye(4))
    """Of the whole door in the world against where its URDF has it, homogeneous, shape (4, 4)."""
    yaw: float = 0.0
    """By which that turns it about the vertical [rad]; the leaf points along α + yaw."""

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
        self.lower_limit, self.upper_limit = self._range()
        self._check_convention()
        self.mass = float(self.model.inertias[1].mass)
        self.inertia = self._inertia_about_hinge()
        self.width, self.height, self.thickness, self.surface_offset = self._leaf_size()
        self._check_closed()
        """`surface_offset`: how far the leaf's face to the vehicle lies before the hinge axis [m]; the constraints take 0."""
        self.frame_depth = self._frame_depth()
        """How far the jambs' boxes reach before the hinge axis, towards the vehicle [m]."""
        hinge = read_joints(urdf)[self.section.hinge]
        self.damping = float(hinge.damping if self.section.damping is None else self.section.damping)
        self.friction = float(hinge.friction if self.section.friction is None else self.section.friction)
        self.stiffness = self.section.stiffness
        self.rest_angle = self.section.rest_angle
        self.friction_rate = self.section.friction_rate

    def link_placements(self, door_angle: float) -> dict[str, Array]:
        """Placement of every link in the world.

        Args:
            door_angle: α [rad].

        Returns:
            Homogeneous matrices of shape (4, 4) by link name.
        """
        data = self._own.get(self.model.createData)
        pinocchio.framesForwardKinematics(self.model, data, np.array([float(door_angle)]))
        return {
            frame.name: np.array(placement.homogeneous)
            for frame, placement in zip(self.model.frames, data.oMf, strict=True)
            if frame.type == pinocchio.FrameType.BODY
        }

    def contact_point(self, door_angle: float, distance_from_hinge: float, height: float) -> Array:
        r"""Point of the plane through hinge axis and leaf, :math:`P_h + [D_V\cos\alpha,\ D_V\sin\alpha,\ D_H]`.

        Args:
            door_angle: α [rad].
            distance_from_hinge: D_V [m].
            height: D_H above the lower end of the hinge line [m].

        Returns:
            Shape (3,), world frame [m].
        """
        offset = distance_from_hinge * leaf_direction(door_angle + self.yaw) + np.array([0.0, 0.0, height])
        return np.asarray(self.hinge_position + offset)

    def onto_face(self, point: Array, door_angle: float) -> Array:
        r"""A point moved along the leaf's normal onto its face to the vehicle, :math:`q + (n_D^T(P_h - q) - d)\,n_D`.

        Args:
            point: q, shape (3,), world frame [m].
            door_angle: α [rad]; d is the `surface_offset`.

        Returns:
            Shape (3,), world frame [m].
        """
        normal = door_normal(door_angle + self.yaw)
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

    def _check_convention(self) -> None:
        """The leaf at angle α must point along [cos α, sin α, 0], and its z axis up."""
        for angle in (0.0, 1.0):
            given = self.link_placements(angle)[self.section.leaf][:3, [0, 2]].T
            allowed = np.array([leaf_direction(angle), [0.0, 0.0, 1.0]])
            if not np.allclose(given, allowed, atol=1e-6):
                raise UrdfError(
                    "the leaf does not turn about +z from the world's x axis",
                    file=self.urdf,
                    field=f"joint {self.section.hinge}",
                    given=f"x and z of the leaf along {given.round(3).tolist()} at {angle} rad",
                    allowed=f"{allowed.round(3).tolist()}: axis 0 0 1, origins without rotation",
                )

    def _range(self) -> tuple[float, float]:
        lower, upper = float(self.model.lowerPositionLimit[0]), float(self.model.upperPositionLimit[0])
        if not lower < upper:
            raise UrdfError(
                "the hinge has no range", file=self.urdf, field=f"joint {self.section.hinge}/limit@upper", given=upper,
                allowed=f"> {lower:g} rad",
            )  # fmt: skip
        return lower, upper

    def _check_closed(self) -> None:
        limits, size = (self.lower_limit, self.upper_limit), (self.width, self.height)
        evidence = closed_at_zero(self.hinge_position, size, limits, list(self._fixed_boxes()))
        if evidence:
            raise UrdfError(
                "the door is closed at 0: to open it would close it", file=self.urdf, field=f"joint {self.section.hinge}",
                given=evidence, allowed="a joint that is π/2 where the door is closed and 0 where it is open by 90°",
            )  # fmt: skip

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
        shapes = read_boxes(self.urdf, self.section.leaf)
        boxes = [shape for shape in shapes if shape is not None]
        if not boxes:
            raise UrdfError(
                "the leaf has no box as collision shape", file=self.urdf, field=f"link {self.section.leaf}/collision",
                given=f"{len(shapes)} shapes, none a box", allowed="a <box> whose first size is the leaf's width",
            )  # fmt: skip
        box = max(boxes, key=lambda box: float(np.prod(box.size)))
        size = np.abs(box.placement[:3, :3]) @ box.size
        frame = self.model.frames[link_index(self.model, self.section.leaf, self.urdf, "door.leaf")]
        center = frame.placement.act(box.placement[:3, 3])
        if size[1] > size[0] or center[0] <= 0.0:
            raise UrdfError(
                "the leaf does not reach along +x of its link", file=self.urdf, field=f"link {self.section.leaf}/collision",
                given=f"{size[0]:g} m along x around {center[0]:g} m, {size[1]:g} m along y around {center[1]:g} m",
                allowed="a leaf whose width is along +x, from the hinge to the latch, and whose thickness is along y",
            )  # fmt: skip
        return float(center[0] + size[0] / 2), float(size[2]), float(size[1]), float(center[1] + size[1] / 2)

    def _frame_depth(self) -> float:
        """Of the boxes beside the doorway that do not move with the leaf; 0 if there are none."""
        hinge, middle = float(self.hinge_position[0]), float(self.hinge_position[1]) + 0.5 * self.width
        beside = [box for box in self._fixed_boxes() if abs(box.center[1] - middle) > box.half[1]]
        return hinge - min([hinge, *(float(box.center[0] - box.half[0]) for box in beside)])

    def _fixed_boxes(self) -> Iterator[FixedBox]:
        """Boxes that do not move with the leaf."""
        for name, placement in self.link_placements(0.0).items():
            if self.model.frames[self.model.getFrameId(name, pinocchio.FrameType.BODY)].parentJoint == 1:
                continue
            for box in read_boxes(self.urdf, name):
                if box is not None:
                    placed = placement @ box.placement
                    yield FixedBox(placed[:3, 3], np.abs(placed[:3, :3]) @ box.size / 2)


def _variant(urdf: Path, section: DoorSection) -> Path:
    """URDF of the door with the section's width and mass of the leaf."""
    written = Door(urdf, section.model_copy(update={"width": None, "mass": None}))
    hinge = float(written.hinge_position[1])
    return write_door_variant(urdf, section.leaf, hinge, written.width, section.width, section.mass)
