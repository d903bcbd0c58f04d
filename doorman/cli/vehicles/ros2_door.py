"""The sensor of the door that is a topic of ROS 2, which only this layer may know."""

from __future__ import annotations

from doorman.hardware.door import DoorSource
from doorman.hardware.vehicle import VehicleConfig

_ROS2 = "ros2:"


def door_source(config: VehicleConfig) -> DoorSource | None:
    """The source, where the configuration names a topic; None where the links make their own.

    Args:
        config: Of the links.
    """
    sensor = config.door_sensor
    if sensor is None or not sensor.source.startswith(_ROS2):
        return None
    from doorman.ros2.door_source import JointStateSource

    return JointStateSource(sensor.source.removeprefix(_ROS2), sensor.joint)
