"""Sensors of the door: where leaf and frame are, by cameras, tags, an encoder, or whatever a callable reads."""

from doorman.hardware.door.config import CameraConfig, DoorSensorConfig, Mark
from doorman.hardware.door.leaf_geometry import LeafGeometry
from doorman.hardware.door.sample import DoorSample, DoorSource, FrameSample, LeafSample, MarkPose
from doorman.hardware.door.sensor import DoorSensor
from doorman.hardware.door.sources import CallableSource, UdpLineSource

__all__ = [
    "CallableSource",
    "CameraConfig",
    "DoorSample",
    "DoorSensor",
    "DoorSensorConfig",
    "DoorSource",
    "FrameSample",
    "LeafGeometry",
    "LeafSample",
    "Mark",
    "MarkPose",
    "UdpLineSource",
]
