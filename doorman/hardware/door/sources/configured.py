"""The source that a configuration names."""

from __future__ import annotations

from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.door.config import CAMERAS, TAGS, DoorSensorConfig
from doorman.hardware.door.sample import DoorSource
from doorman.hardware.door.sources.camera_objects import CameraObjects
from doorman.hardware.door.sources.udp_line import UdpLineSource
from doorman.hardware.mocap import MocapReceiver


def source_of(config: DoorSensorConfig, cameras: MocapReceiver | None, clock: Clock = REAL_TIME) -> DoorSource:
    """The source of a configuration; it is not open."""
    if config.source == CAMERAS:
        if cameras is None:
            raise BackendError(
                "there are no cameras", field="door_sensor.source", given=CAMERAS, allowed="another source"
            )
        return CameraObjects(cameras)
    if config.source == TAGS:
        from doorman.hardware.door.tags.source import TagSource

        return TagSource(config)
    if config.source.startswith("udp:"):
        return UdpLineSource(config.source, clock)
    raise BackendError("the program has to hand on the source", field="door_sensor.source", given=config.source,
                       allowed="VehicleLinks(door=...); doorman fly makes that of a ROS 2 topic itself")  # fmt: skip
