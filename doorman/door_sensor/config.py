"""Settings of a sensor of the door: who measures, what is stuck on leaf and frame, the camera, and how the leaf moves."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import Positive, Range, check_fields
from doorman.exceptions import BackendError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.quaternions import from_rotation

CAMERAS, TAGS, PROGRAM = "cameras", "tags", "program"
_PATTERN = re.compile(rf"{CAMERAS}|{TAGS}|{PROGRAM}|udp:(?:[A-Za-z0-9.-]+:)?\d{{1,5}}|ros2:[\w/]+", re.ASCII)
_ALLOWED = '"cameras", "tags", "udp:[HOST:]PORT", "ros2:TOPIC" or "program"'

Triple = tuple[float, float, float]
_Pixels = Annotated[int, Range(64, 8192, "pixel")]
_Focal = Annotated[float, Range(10.0, 1e5, "pixel")]


@dataclass(frozen=True)
class Mark:
    """What is stuck on leaf or frame: an object of the cameras, or a tag.

    Raises:
        BackendError: if a value is out of range.
    """

    name: str
    """Name of the object in the cameras' stream, or number of the tag, 0 to 586."""
    position: Triple = (0.0, 0.0, 0.0)
    """Position of the object's origin, or the tag's middle: in the leaf's link, or in the world of the door's URDF [m]."""
    attitude: Triple = (0.0, 0.0, 0.0)
    """Attitude Φ of its axes there. Those of a tag: x to its right, y up, z out of the paper [rad]."""
    size: Annotated[float, Range(0.01, 2.0, "m")] = 0.16
    """Edge of a tag's black square [m]."""

    def __post_init__(self) -> None:
        if not self.name:
            raise BackendError(
                "no name", field="door_sensor.name", given=self.name, allowed="an object, or a tag's number"
            )
        check_fields(self, "door_sensor.")
        if not all(math.isfinite(value) for value in (*self.position, *self.attitude)):
            raise BackendError(
                "not finite", field="door_sensor", given=(self.position, self.attitude), allowed="numbers"
            )

    @property
    def tag(self) -> int:
        """Number of the tag.

        Raises:
            BackendError: if the name is none.
        """
        if not (self.name.isdecimal() and int(self.name) <= 586):
            raise BackendError("not a tag", field="door_sensor.name", given=self.name, allowed="0 to 586")
        return int(self.name)


@dataclass(frozen=True)
class CameraConfig:
    """A camera on the vehicle that sees tags: a pinhole, with OpenCV's distortion.

    Raises:
        BackendError: if a value is out of range.
    """

    device: str = "/dev/video0"
    """V4L2 device."""
    width: _Pixels = 640
    """Width of the picture [pixel]."""
    height: _Pixels = 480
    """Height of the picture [pixel]."""
    fx: _Focal = 343.0
    """Focal length along the picture's rows [pixel]."""
    fy: _Focal = 343.0
    """Focal length along its columns [pixel]."""
    cx: float = 319.5
    """Column of the principal point, 0 in the middle of the first pixel [pixel]."""
    cy: float = 239.5
    """Row of the principal point [pixel]."""
    distortion: tuple[float, ...] = ()
    """k1, k2, p1, p2, k3 and so on, as OpenCV's calibration writes them."""
    position: Triple = (0.12, 0.0, 0.0)
    """Position of the camera, body frame [m]."""
    attitude: Triple = (0.0, 0.0, 0.0)
    """Attitude Φ of the camera in the body; with zeros it looks forward, along x [rad]."""
    rate: Annotated[float, Range(1.0, 1000.0, "1/s")] = 30.0
    """Pictures per second [1/s]."""
    latency: Annotated[float, Range(0.0, 1.0, "s")] = 0.03
    """Between exposure and the arrival of a picture [s]."""

    def __post_init__(self) -> None:
        check_fields(self, "door_sensor.camera.")


@dataclass(frozen=True)
class DoorSensorConfig:
    """A sensor of the door.

    Raises:
        BackendError: if a value is out of range, or nothing is measured.
    """

    source: str = CAMERAS
    """Who measures: `cameras`, those that see the vehicle; `tags`, seen by a camera on it; `udp:[HOST:]PORT`, lines of text;
    `ros2:TOPIC`, messages of `sensor_msgs/JointState`; `program`, which hands a source of its own to `VehicleLinks`."""
    leaf: Mark | None = None
    """What is stuck on the leaf; for cameras and tags."""
    frame: Mark | None = None
    """What is stuck on the frame or the wall beside it; for cameras and tags."""
    camera: CameraConfig | None = None
    """Camera that sees the tags; for tags."""
    joint: str = ""
    """Name of the door's joint in the messages of a ROS 2 topic; empty: the first one."""
    deviation: Positive = 0.005
    """Standard deviation of a joint value that comes without one, as from encoders [rad, or m]."""
    place_deviation: Positive = 0.002
    """Standard deviation of a mark's position by cameras or tags [m]."""
    turn_deviation: Positive = 0.01
    """Standard deviation of a mark's attitude [rad]."""
    stale_after: Positive = 0.3
    """Age from which on the newest reading counts as none [s]."""
    motion: LeafGeometry | None = None
    """How the leaf moves."""

    def __post_init__(self) -> None:
        if _PATTERN.fullmatch(self.source) is None:
            raise BackendError("no such source", field="door_sensor.source", given=self.source, allowed=_ALLOWED)
        check_fields(self, "door_sensor.")
        if self.source in (CAMERAS, TAGS) and not self.marks:
            raise BackendError("nothing to see", field="door_sensor.leaf", given=None, allowed="leaf, frame, or both")
        if self.source == TAGS:
            for mark in self.marks.values():
                mark.tag  # noqa: B018  # an error if it is none

    @property
    def marks(self) -> dict[str, Mark]:
        """What can be seen, by where it is stuck: `leaf`, `frame`, or both."""
        return {part: mark for part, mark in (("leaf", self.leaf), ("frame", self.frame)) if mark is not None}


_ENDLESS = 1e6
"""Limit of an endless joint, beyond any real one: JSON knows no infinity."""


@dataclass(frozen=True)
class LeafGeometry:
    r"""Motion of a leaf's link in the world of its URDF; make one with `of`.

    With the link's placement :math:`T_0` where the joint is at zero, a unit axis a and a point c on it, a hinge at q has
    :math:`T(q) = t(c)\,R_a(q)\,t(-c)\,T_0`, and a slide :math:`T(q) = t(q a)\,T_0`.
    """

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
            back @ door.link_placements(door.angle_of_joint(value))[door.section.leaf] for value in (0.0, math.pi / 2)
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
        """Joint value of a seen link, given twice: by its rotation, and by where the mark is.

        Both are weighed by their deviations: a mark 0.7 m from the hinge says more by its place than by its attitude.

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
            w, *along = from_rotation(rotation @ np.array(self.rotation).T)
            by_turn = 2.0 * math.atan2(float(axis @ along), w)
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
