"""What a source of the door brings, and what of it are readings for an estimate: the leaf's joint value, the frame's place.

A pose from the vehicle's camera is put into the world by the pose that the vehicle had when the picture was taken. The leaf's
pose is taken against the measured frame where there is one, else against the map. What cannot be a reading of this door is none,
and reported once: a pose that is upside down or of another object, a joint value beyond the joint's range, numbers that are not
finite.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from doorman.arrays import Array
from doorman.background import EventLog
from doorman.copying import Uncopied
from doorman.door_sensor.config import DoorSensorConfig
from doorman.exceptions import BackendError
from doorman.kinematics.quaternions import Quaternion, Vector, to_rotation
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.signals import FrameReading, LeafReading, Source


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
    """Brings what is known of the door. `doorman.hardware.door` has those that ship."""


class CallableSource(Uncopied):
    """Asks a callable at every tick; it must answer at once.

    Args:
        read: Returns the newest sample.
    """

    def __init__(self, read: Callable[[], DoorSample]) -> None:
        self._read = read

    def open(self) -> None:
        """Do nothing: the callable is ready."""

    def read(self) -> DoorSample:
        """Newest sample."""
        return self._read()

    def stop(self) -> None:
        """Do nothing."""


_MOST_OFF, _MOST_TURNED = 0.1, math.radians(10.0)
"""Largest error of a leaf's mark against every place of the leaf: as of the map of the door [m, rad]."""
_UNPLACED = "not a pose, or of a time at which the vehicle's own is not known"
_NUMBERS = re.compile(r"[\d.+-]+")


class _VehiclePose(NamedTuple):
    time: float  # [s]
    position: Array  # P, shape (3,), world frame [m]
    attitude: Array  # Φ, shape (3,) [rad]


class DoorSensor(Uncopied):
    """Readings of one flight.

    Args:
        source: Who measures.
        config: Deviations, marks, and how the leaf moves.
    """

    def __init__(self, source: DoorSource, config: DoorSensorConfig) -> None:
        if config.motion is None:
            raise BackendError(
                "how the leaf moves is not known", field="door_sensor.motion", allowed="LeafGeometry.of(door)"
            )
        self.source, self.config, self._motion = source, config, config.motion
        self._poses: deque[_VehiclePose] = deque()
        self._events = EventLog[tuple[float, str]]()
        self._faults = {"leaf": "", "frame": "", "": ""}
        self._judged: tuple[LeafSample | None, LeafReading | str] = None, ""
        self._frame: FrameReading | None = None

    def note_pose(self, time: float, position: Array, attitude: Array) -> None:
        """Take in where the vehicle was.

        Args:
            time: When that was true [s].
            position: P, shape (3,), world frame [m].
            attitude: Φ, shape (3,) [rad].
        """
        poses = self._poses
        if poses and time <= poses[-1].time:
            return
        poses.append(_VehiclePose(time, position, attitude))
        while time - poses[0].time > self.config.stale_after:  # older pictures count as none
            poses.popleft()

    def read(self, now: float, epoch: float = 0.0) -> tuple[LeafReading | None, FrameReading | None]:
        """What can be used now.

        Args:
            now: Time of the call [s].
            epoch: Subtracted from the readings' times [s].

        Returns:
            Leaf and frame.
        """
        try:
            sample, fault = self.source.read(), ""
        except Exception as error:  # whatever it is: the vehicle flies without the sensor
            sample, fault = DoorSample(), f"{type(error).__name__}: {error}"
        self._tell("", now, fault)
        frame: FrameReading | str = self._too_old("frame", now, sample.frame)
        if sample.frame is not None and not frame:
            frame = self._frame_of(sample.frame, epoch)
            self._frame = None if isinstance(frame, str) else frame
        self._tell("frame", now, frame)
        leaf: LeafReading | str = self._too_old("leaf", now, sample.leaf)
        if sample.leaf is not None and not leaf:
            if sample.leaf != self._judged[0]:
                self._judged = sample.leaf, self._leaf_of(sample.leaf, epoch)
            leaf = self._judged[1]
        self._tell("leaf", now, leaf)
        return None if isinstance(leaf, str) else leaf, None if isinstance(frame, str) else frame

    def events(self) -> list[tuple[float, str]]:
        """Time and words of every change since the last call."""
        return self._events.take()

    def _too_old(self, part: str, now: float, sample: LeafSample | FrameSample | None) -> str:
        """What is wrong with the time of a sample; nothing where none is expected."""
        if sample is None:
            expected = self.config.marks or ("leaf",)
            return "no reading" if self._faults[part] or part in expected else ""
        if -1e-3 <= now - sample.time <= self.config.stale_after:
            return ""
        return "the reading is old" if sample.time < now else "the reading is of a time to come"

    def _frame_of(self, sample: FrameSample, epoch: float) -> FrameReading | str:
        """The reading, or why there is none."""
        placed = self._in_world(sample.pose, sample.time)
        if placed is None:
            return _UNPLACED
        position, rotation = placed
        lean = math.acos(min(max(float(rotation[2, 2]), -1.0), 1.0))
        if lean > _MOST_TURNED:
            return f"the mark on the frame leans by {math.degrees(lean):.0f}°: another object, or turned"
        yaw = math.atan2(float(rotation[1, 0] - rotation[0, 1]), float(rotation[0, 0] + rotation[1, 1]))
        mark = np.zeros(3) if self.config.frame is None else np.array(self.config.frame.position)
        place = position + rotation @ mark  # where the mark is seen: its place is known better than its attitude
        return FrameReading(
            place - rotation_body_to_world((0.0, 0.0, yaw)) @ mark, yaw, sample.time - epoch, self.config.place_deviation,
            self.config.turn_deviation,
        )  # fmt: skip

    def _leaf_of(self, sample: LeafSample, epoch: float) -> LeafReading | str:
        """The reading, or why there is none."""
        config, motion, joint, deviation = self.config, self._motion, sample.joint, self.config.deviation
        if sample.pose is None:
            if joint is None or not math.isfinite(joint):
                return f"the reading is {joint}"
        else:
            placed = self._in_world(sample.pose, sample.time)
            if placed is None:
                return _UNPLACED
            known = self._frame
            origin, yaw = (motion.door_position, motion.door_yaw) if known is None else (known.position, known.yaw)
            back = rotation_body_to_world((0.0, 0.0, -yaw))
            mark = (0.0, 0.0, 0.0) if config.leaf is None else config.leaf.position
            joint, deviation, off, turned = motion.joint(
                back @ (placed[0] - np.array(origin)), back @ placed[1], mark, config.place_deviation, config.turn_deviation
            )  # fmt: skip
            if off > _MOST_OFF or turned > _MOST_TURNED:
                words = f"{100.0 * off:.0f} cm and {math.degrees(turned):.0f}° off its way: another object, or turned"
                return f"the mark on the leaf is {words}"
        beyond = _MOST_OFF if motion.slides else _MOST_TURNED
        if not motion.limits[0] - beyond <= joint <= motion.limits[1] + beyond:
            return f"the leaf is seen at {joint:.2f}, beyond its joint's range"
        return LeafReading(float(joint), sample.time - epoch, float(sample.deviation or deviation))

    def _in_world(self, pose: MarkPose, time: float) -> tuple[Array, Array] | None:
        """Position and rotation in the world, if they are known."""
        position, quaternion = np.array(pose.position, float), np.array(pose.quaternion, float)
        if not (np.isfinite(position).all() and np.isfinite(quaternion).all() and np.linalg.norm(quaternion) > 0.5):
            return None
        rotation = to_rotation(quaternion)
        if not pose.in_body:
            return position, rotation
        poses = self._poses
        if not poses or not poses[0].time <= time <= poses[-1].time + 0.05:
            return None
        after = next((k for k, one in enumerate(poses) if one.time >= time), len(poses) - 1)
        (start, place, turn), (end, place_after, turn_after) = poses[max(after - 1, 0)], poses[after]
        share = (time - start) / (end - start) if end > start else 0.0
        change = turn_after - turn
        change[2] = math.remainder(change[2], 2.0 * math.pi)
        body = rotation_body_to_world(turn + share * change)
        return place + share * (place_after - place) + body @ position, body @ rotation

    def _tell(self, part: str, now: float, found: object) -> None:
        """Write down what is wrong, or that nothing is; once."""
        fault = found if isinstance(found, str) else ""
        kind = _NUMBERS.sub("", fault)  # what is wrong, not by how much
        if kind == self._faults[part]:
            return
        self._faults[part] = kind
        subject = part or "door sensor"
        self._events.write((now, f"{subject}: {fault}" if fault else f"{subject}: readings are usable"))
