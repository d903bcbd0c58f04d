"""Sensors of the door: where leaf and frame are, by cameras, tags, an encoder, or whatever a callable reads."""

from doorman.door_sensor.config import CameraConfig, DoorSensorConfig, LeafGeometry, Mark
from doorman.door_sensor.sensor import (
    CallableSource,
    DoorSample,
    DoorSensor,
    DoorSource,
    FrameSample,
    LeafSample,
    MarkPose,
)
from doorman.hardware.door.sources import UdpLineSource

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
