"""Leaf and frame as further objects of the cameras that see the vehicle: Vicon, OptiTrack, Qualisys, VRPN."""

from __future__ import annotations

from dataclasses import replace

from doorman.hardware.door.config import CAMERAS, DoorSensorConfig
from doorman.hardware.door.sample import DoorSample, FrameSample, LeafSample, MarkPose
from doorman.hardware.mocap import MocapConfig, MocapReceiver, PoseSample


def objects_beside(cameras: MocapConfig, sensor: DoorSensorConfig | None) -> dict[str, MocapConfig]:
    """Further objects that a receiver follows, by `leaf` and `frame`."""
    if sensor is None or sensor.source != CAMERAS:
        return {}
    marks = {"leaf": sensor.leaf, "frame": sensor.frame}
    return {
        part: replace(
            cameras, object_name=mark.name, object_position=mark.position, object_attitude=mark.attitude,
        )
        for part, mark in marks.items() if mark is not None
    }  # fmt: skip


class CameraObjects:
    """What a receiver sees of the door; it is opened and stopped with the vehicle's poses."""

    def __init__(self, receiver: MocapReceiver) -> None:
        self._receiver = receiver

    def open(self) -> None:
        """Do nothing: the receiver is opened by who flies by it."""

    def read(self) -> DoorSample:
        """Newest poses of both; one that is not fresh is none."""
        leaf, frame = self._pose("leaf"), self._pose("frame")
        return DoorSample(
            None if leaf is None else LeafSample(leaf.time, pose=_of_link(leaf)),
            None if frame is None else FrameSample(frame.time, _of_link(frame)),
        )

    def stop(self) -> None:
        """Do nothing."""

    def _pose(self, part: str) -> PoseSample | None:
        if part not in self._receiver.beside:
            return None
        sample = self._receiver.read_beside(part)
        return sample if sample.fresh else None


def _of_link(sample: PoseSample) -> MarkPose:
    x, y, z = sample.position.tolist()
    w, qx, qy, qz = sample.quaternion.tolist()
    return MarkPose((x, y, z), (w, qx, qy, qz))
