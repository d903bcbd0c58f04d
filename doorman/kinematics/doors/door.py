"""Door: how its leaf moves, its size and the torques in its joint, all from its URDF and the scenario."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import numpy as np
import pinocchio
from numpy.typing import ArrayLike

from doorman.arrays import Array, frozen
from doorman.copying import PerThread
from doorman.exceptions import UrdfError
from doorman.gravity import weight_of
from doorman.kinematics.doors.leaf.leaf_in_world import LeafInWorld
from doorman.kinematics.doors.leaf.leaf_motion import SLIDE_RADIUS, weight_torque
from doorman.kinematics.doors.urdf.joints import hinge_joint, levers, places, standing_joints, standing_values
from doorman.kinematics.doors.urdf.leaf_in_plane import ALONG, LeafInPlane
from doorman.kinematics.doors.urdf.leaf_on_joint import LEANS, LeafOnJoint
from doorman.kinematics.doors.urdf.leaf_on_slide import LeafOnSlide, read_leaf
from doorman.kinematics.doors.variants.variant import write_door_variant
from doorman.kinematics.urdf.elements import read_joints
from doorman.kinematics.urdf.robot import joint_placements_along, link_index, links_of, load_pinocchio, with_standing
from doorman.scenario import ContactSection, DoorSection

Side = Literal["push", "pull"]

AT_ITS_STOP = 0.01
"""A leaf that is nearer to its stop stands there: half a degree, as drawings round a right angle [rad]."""
_OF_LEAF = 0.85
"""Where a tip touches a lever whose contact is not named, as a share of its reach from the axis; on a leaf at most so far out."""


class Door(LeafInWorld):
    r"""Leaf on one joint, a hinge of any direction or a slide, anywhere in the world. Threads may share it.

    Its angle α is π/2 where it is closed and grows as the leaf moves towards the vehicle, whatever the URDF's joint says there:
    it falls as a door is pushed open, and grows as one is pulled open. With the unit vectors `into` (from the vehicle through
    the closed leaf), `along` (from hinge to latch along it) and `up` (along the hinge), leaf and normal are

    .. math:: c = \cos\alpha\,i + \sin\alpha\,a, \qquad n_D = \sin\alpha\,i - \cos\alpha\,a .

    n_D points away from the vehicle. A slide keeps both; its α is its way in units of `leaf_motion.SLIDE_RADIUS`.

    Args:
        urdf: Path of the URDF; `self.urdf` is another file where the section changes the leaf.
        section: Names of leaf and joint, where the joint is closed, the torques in it, and the leaf's width and mass if other
            than the URDF's.
        side: Of the leaf that the vehicle is on: where the door is pushed open, `push`, or pulled open, `pull`.
        contact: Where the tip touches; by default on the outermost face, anywhere.

    Raises:
        UrdfError: if leaf or joint is missing, a slide is too steep, the leaf has no mass or no shape, or something on the leaf
            moves.
    """

    placement: Array = frozen(np.eye(4))
    """Placement of the whole door in the world, from where its URDF has it, homogeneous, shape (4, 4)."""
    yaw: float = 0.0
    """By which that turns it about the vertical [rad]."""

    def __init__(
        self,
        urdf: Path,
        section: DoorSection | None = None,
        side: Side = "push",
        contact: ContactSection | None = None,
    ) -> None:
        self.section, self.side = section or DoorSection(), side
        self._turns = -1.0 if side == "push" else 1.0  # of α, as the door opens
        if self.section.width is not None or self.section.mass is not None:
            urdf = _variant(urdf, self.section)
        self.urdf = urdf
        full = load_pinocchio(urdf, endless=False)
        leaf = link_index(full, self.section.leaf, urdf, "door.leaf")
        self._hinge = hinge_joint(urdf, full, self.section.hinge)
        stands = standing_values(self.section)
        unlatched = "latched" in self.section.model_fields_set and not self.section.latched
        self.standing_joints = standing_joints(urdf, full, self._hinge, stands, unlatched)
        """Joints that could move, and neither carry the leaf nor hang on it; they stand at zero."""
        locked = [i for i in range(1, full.njoints) if i != self._hinge]
        self.model = with_standing(full, locked, places(full, stands))
        self.links = links_of(self.model)
        self._own: PerThread[pinocchio.Data] = PerThread()
        if full.frames[leaf].parentJoint != self._hinge:
            raise UrdfError(
                "the hinge does not move the leaf", file=urdf, field="door.leaf", given=self.section.leaf,
                allowed=f"a link moved by joint '{self.section.hinge}'",
            )  # fmt: skip
        self.touched = frozenset({self.section.leaf, *levers(urdf, self.section)})
        """Links that the tip may touch: the leaf, and levers on it that were turned first."""
        leaf_on_joint = read_leaf(urdf, self.model, self.section, contact, self._turns)
        self.slides = isinstance(leaf_on_joint, LeafOnSlide)
        self.in_plane = isinstance(leaf_on_joint, LeafInPlane)
        self.endless = leaf_on_joint.endless
        """Whether the joint is continuous, and nothing stops it at the ends of its range."""
        self.turn, self.slide = (0.0, SLIDE_RADIUS) if self.slides else (1.0, 0.0)
        self.per_angle = self.turn + self.slide
        self.unit = leaf_on_joint.unit
        lower, upper = leaf_on_joint.limits
        self.closed, self._sense = leaf_on_joint.closed.value, leaf_on_joint.sense
        """Value of the URDF's joint where the door is closed [rad or m]."""
        self.closed_is_guessed = leaf_on_joint.closed.guessed
        """Whether neither `door.closed` nor a jamb tells that value."""
        self._take_axes(*leaf_on_joint.axes)
        self.vertical = bool(self.up[2] == 1.0) and not self.slides
        self.lies = bool(abs(self.up[2]) < LEANS) and not self.slides
        """Whether it is a hinge that lies rather than stands, as a hatch's: the doorway has no jamb beside the latch."""
        self.along_in_leaf = frozen(leaf_on_joint.axes_in_leaf[1])
        """`along` in the axes of the link that the joint carries, shape (3,)."""
        self.upright = not (self.slides or self.lies)
        """Whether it is a hinge that stands, with a jamb on either side of the doorway."""
        self.hand = float(np.sign(np.cross(self.into, self.along) @ self.up))
        ahead = -self.up if self.in_plane else self.into
        self.azimuth = math.atan2(ahead[1], ahead[0])
        shut = self.closed if self.section.preload > 0.0 else lower if self._sense > 0.0 else upper
        self.stop = self.angle_of_joint(shut)
        """α where the leaf shuts no farther: where its joint ends, or closed if a closer presses it into its frame [rad]."""
        self.lower_limit, self.upper_limit = sorted(
            (self.stop, self.angle_of_joint(upper if self._sense > 0.0 else lower))
        )
        """Least and largest α [rad]."""
        self.mass, inertia = leaf_on_joint.mass_and_inertia()
        self.inertia = inertia * self.per_angle**2
        self.width, self.height, self.thickness, self.surface_offset = leaf_on_joint.size.sides
        """`surface_offset`: how far the leaf's face to the vehicle lies before the hinge axis [m]."""
        self.hinge_position = frozen(leaf_on_joint.size.corner)
        self.weight = frozen(self._weight(leaf_on_joint.center_of_mass))
        """Weight times place of the centre of mass along leaf and normal, or times `per_angle`, shape (2,) [N m]."""
        self._center = self.in_doorway(leaf_on_joint.center_of_mass - self.hinge_position)
        self.handle = None if contact is None or contact.named is None else self._handle(leaf_on_joint, contact)
        """Place of a contact that the URDF has: D_V, D_H, and how far it lies before the hinge axis [m]."""
        self.contact_offset = self._contact_offset(leaf_on_joint, contact)
        self.panel = self._panel(leaf_on_joint)
        """Plane beside the way of a slide's contact: normal in the doorway, and distance from P_h along it [m]; None without."""
        self.frame_depth, self.frame_back = leaf_on_joint.frame_depth()
        """How far the jambs' boxes reach before the hinge axis, towards the vehicle, and how far behind it [m]."""
        self.framed = bool(leaf_on_joint.fixed_boxes)
        """Whether anything stands around the leaf."""
        given = self.section.frame_height
        self.frame_height = leaf_on_joint.frame_height() if given is None else given
        """Height of the opening above the leaf's lower edge; None without a lintel [m]."""
        hinge, arm = read_joints(urdf)[self.section.hinge], self.per_angle
        self.damping = arm**2 * float(hinge.damping if self.section.damping is None else self.section.damping)
        self.friction = arm * float(hinge.friction if self.section.friction is None else self.section.friction)
        self.stiffness = arm**2 * self.section.stiffness
        self.rest_angle = self.section.rest_angle
        self.friction_rate = self.section.friction_rate
        self.closing_torque = self.torque_of_closer(arm * self.section.preload)
        """Torque of the closer's preload, in the sense of damping [N m]."""
        self.stiction = arm * self.section.stiction
        if any(self.section.position) or self.section.yaw:
            self._stand(self.hinge_position, *standing(self.section.position, self.section.yaw, self.hinge_position))

    @property
    def largest_opening(self) -> float:
        """Largest opening that the joint's limits leave [rad or m]."""
        return max(self.opening_of(self.lower_limit), self.opening_of(self.upper_limit))

    def at_its_stop(self, door_angle: float) -> bool:
        """Whether a leaf at α shuts no farther."""
        return abs(door_angle - self.stop) < AT_ITS_STOP

    def link_placements(self, door_angle: float) -> dict[str, Array]:
        """Placement of every link in the world."""
        joints = self.joint_placements_along(np.array([door_angle]))[0]
        return {name: joints[link.joint] @ link.placement for name, link in self.links.items()}

    def joint_placements_along(self, door_angles: Array) -> Array:
        """Placements of what carries the `links`, in the world, at each of m angles."""
        values = np.array([[self.joint_value(float(angle))] for angle in door_angles])
        placed = joint_placements_along(self.model, self._own.get(self.model.createData), values)
        return placed if self.yaw == 0.0 and not self.placement[:3, 3].any() else np.asarray(self.placement @ placed)

    def _stand(self, before: Array, hinge: Array, yaw: float) -> None:
        """Stand elsewhere: turned by an angle about the vertical through the hinge, which moves from one place to another."""
        moved = np.eye(4)
        moved[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
        moved[:3, 3] = hinge - moved[:3, :3] @ before
        self.hinge_position, self.placement = frozen(hinge), frozen(moved @ self.placement)
        self.yaw, self.azimuth = self.yaw + yaw, self.azimuth + yaw
        turn = moved[:3, :3]
        self._take_axes(turn @ self.into, turn @ self.along, turn @ self.up)

    def weight_torque(self, door_angle: float) -> float:
        """Torque G(α) of the leaf's own weight, in the sense of damping [N m]."""
        if self.vertical:
            return 0.0
        leaf, normal = self.leaf_direction(door_angle), self.normal(door_angle)
        return float(weight_torque(self.weight[0], self.weight[1], leaf[2], normal[2]))

    def hinge_torque(self, door_angle: float, door_rate: float) -> float:
        r"""Torque :math:`b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) \pm \tau_p + G` against motion."""
        friction = self.friction * np.tanh(door_rate / self.friction_rate)
        spring = self.stiffness * (door_angle - self.rest_angle)
        return float(self.damping * door_rate + friction + spring + self.closing_torque) + self.weight_torque(
            door_angle
        )

    def _weight(self, center_of_mass: Array) -> Array:
        if self.slides:
            return np.array([weight_of(self.mass) * self.per_angle, 0.0])
        away = center_of_mass - self.hinge_position
        return weight_of(self.mass) * np.array([away @ self.along, away @ self.into])

    def _panel(self, leaf_on_joint: LeafOnJoint) -> tuple[Array, float] | None:
        if self.handle is None and not self.in_plane:
            return None
        along, up, before = self.handle or (0.0, self.height, 0.0)
        place = self.hinge_position + self.from_doorway(np.array([-before, along, up]))
        plane = leaf_on_joint.beside(place)
        if plane is None:
            return None
        normal, distance = plane
        return self.in_doorway(normal), distance - float(normal @ self.hinge_position)

    def place_on_face(self, contact: ContactSection) -> tuple[float, float]:
        """D_V and D_H of a tip that touches the face [m]: the middle of a slide's, and of a hatch's along its hinge."""
        if self.slides:
            return 0.5 * self.width, 0.5 * self.height
        given, distance, height = contact.model_fields_set, contact.distance_from_hinge, contact.height
        if "distance_from_hinge" not in given:
            distance = _OF_LEAF * self.width if self.in_plane else min(distance, _OF_LEAF * self.width)
        if "height" not in given:
            height = min(height, _OF_LEAF * self.height)
        return distance, 0.5 * self.height if self.lies else height

    def _contact_offset(self, leaf_on_joint: LeafOnJoint, contact: ContactSection | None) -> float:
        if self.handle is not None:
            return self.handle[2]
        if contact is None:
            return self.surface_offset
        return leaf_on_joint.face_offset(self.place_on_face(contact))

    def _handle(self, leaf_on_joint: LeafOnJoint, contact: ContactSection) -> tuple[float, float, float]:
        point, outward = leaf_on_joint.contact(self.closed, self.into)
        if outward is not None and not self.in_plane and outward @ -self.normal(0.5 * math.pi) < ALONG:
            raise UrdfError(
                "the contact does not look away from the leaf", file=self.urdf, field=f"contact.{contact.named}",
                given=f"away from it along {outward.round(3).tolist()} where the door is closed",
                allowed=f"{(-self.normal(0.5 * math.pi)).round(3).tolist()}, within {math.degrees(math.acos(ALONG)):.0f}°",
            )  # fmt: skip
        into, along, up = self.in_doorway(point - self.hinge_position)
        return float(along), float(up), -float(into)


def standing(position: ArrayLike, yaw: float, hinge: Array) -> tuple[Array, float]:
    """Where the hinge is of a door whose URDF's origin is at a position, turned by a yaw."""
    x, y, z = hinge.tolist()
    turned = [math.cos(yaw) * x - math.sin(yaw) * y, math.sin(yaw) * x + math.cos(yaw) * y, z]
    return np.asarray(position, float) + turned, yaw


def _variant(urdf: Path, section: DoorSection) -> Path:
    """URDF of the door with the section's width and mass of the leaf."""
    as_drawn = {"width": None, "mass": None, "position": (0.0, 0.0, 0.0), "yaw": 0.0}
    written = Door(urdf, section.model_copy(update=as_drawn))
    if written.slides and section.width is not None:
        raise UrdfError(
            "only a leaf on a hinge can be made wider", file=urdf, field="door.width", given=section.width,
            allowed="the URDF's, by leaving door.width out",
        )  # fmt: skip
    return write_door_variant(
        urdf, section.leaf, written.hinge_position, written.along_in_leaf, written.along, written.width,
        section.width, section.mass,
    )  # fmt: skip
