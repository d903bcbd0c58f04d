"""Settings of a sensor of the door: who measures, what is stuck on leaf and frame, and the camera that sees tags."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from doorman.exceptions import BackendError
from doorman.hardware.door.leaf_geometry import LeafGeometry

CAMERAS, TAGS, PROGRAM = "cameras", "tags", "program"
_PATTERN = re.compile(rf"{CAMERAS}|{TAGS}|{PROGRAM}|udp:(?:[A-Za-z0-9.-]+:)?\d{{1,5}}|ros2:[\w/]+", re.ASCII)
_ALLOWED = '"cameras", "tags", "udp:[HOST:]PORT", "ros2:TOPIC" or "program"'

Triple = tuple[float, float, float]


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
    size: float = 0.16
    """Edge of a tag's black square [m]."""

    def __post_init__(self) -> None:
        if not self.name:
            raise BackendError(
                "no name", field="door_sensor.name", given=self.name, allowed="an object, or a tag's number"
            )
        if not (math.isfinite(self.size) and 0.01 <= self.size <= 2.0):
            raise BackendError("out of range", field="door_sensor.size", given=self.size, allowed="0.01 to 2 m")
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
    width: int = 640
    """Width of the picture [pixel]."""
    height: int = 480
    """Height of the picture [pixel]."""
    fx: float = 343.0
    """Focal length along the picture's rows [pixel]."""
    fy: float = 343.0
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
    rate: float = 30.0
    """Pictures per second [1/s]."""
    latency: float = 0.03
    """Between exposure and the arrival of a picture [s]."""

    def __post_init__(self) -> None:
        for name, low, high in (
            ("width", 64, 8192), ("height", 64, 8192), ("fx", 10.0, 1e5), ("fy", 10.0, 1e5), ("rate", 1.0, 1000.0),
            ("latency", 0.0, 1.0),
        ):  # fmt: skip
            value = getattr(self, name)
            if not (math.isfinite(value) and low <= value <= high):
                raise BackendError(
                    "out of range", field=f"door_sensor.camera.{name}", given=value, allowed=f"{low:g} to {high:g}"
                )


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
    deviation: float = 0.005
    """Standard deviation of a joint value that comes without one, as from encoders [rad, or m]."""
    place_deviation: float = 0.002
    """Standard deviation of a mark's position by cameras or tags [m]."""
    turn_deviation: float = 0.01
    """Standard deviation of a mark's attitude [rad]."""
    stale_after: float = 0.3
    """Age from which on the newest reading counts as none [s]."""
    motion: LeafGeometry | None = None
    """How the leaf moves."""

    def __post_init__(self) -> None:
        if _PATTERN.fullmatch(self.source) is None:
            raise BackendError("no such source", field="door_sensor.source", given=self.source, allowed=_ALLOWED)
        for name in ("deviation", "place_deviation", "turn_deviation", "stale_after"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise BackendError("out of range", field=f"door_sensor.{name}", given=value, allowed="> 0")
        if self.source in (CAMERAS, TAGS) and self.leaf is None and self.frame is None:
            raise BackendError("nothing to see", field="door_sensor.leaf", given=None, allowed="leaf, frame, or both")
        if self.source == TAGS:
            for mark in (self.leaf, self.frame):
                if mark is not None:
                    mark.tag  # noqa: B018  # an error if it is none
