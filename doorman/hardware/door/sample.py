"""What a source of the door brings: the leaf as a joint value or a pose, the frame as a pose, each with its own time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from doorman.hardware.interface import Source
from doorman.hardware.quaternions import Quaternion, Vector


@dataclass(frozen=True)
class MarkPose:
    """A pose of a link of the door."""

    position: Vector
    """Position of the link's origin [m]."""
    quaternion: Quaternion
    """[w, x, y, z], link to world, or to the body."""
    in_body: bool = False
    """Whether it is seen from the vehicle: in its body frame rather than in the world."""


@dataclass(frozen=True)
class LeafSample:
    """Where the leaf is: by the value of its joint, or by the pose of the link that it is in the URDF."""

    time: float
    """When that was true, by `time.monotonic` [s]."""
    joint: float | None = None
    """[rad, or m]."""
    pose: MarkPose | None = None
    deviation: float | None = None
    """Standard deviation of the joint's value [rad, or m]; None: as `door_sensor.deviation`, or as follows from the pose."""


@dataclass(frozen=True)
class FrameSample:
    """Where the door's frame is: the root link of its URDF, which has the leaf's world in its origin."""

    time: float
    """When that was true, by `time.monotonic` [s]."""
    pose: MarkPose


@dataclass(frozen=True)
class DoorSample:
    """Newest of both; None where nothing has been seen."""

    leaf: LeafSample | None = None
    frame: FrameSample | None = None


@runtime_checkable
class DoorSource(Source[DoorSample], Protocol):
    """Brings what is known of the door. `doorman.hardware.door.sources` has those that ship."""
