"""Readings of the door from a topic of `sensor_msgs/JointState`: an encoder that ROS 2 knows."""

from __future__ import annotations

import time
from typing import Any

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from doorman.copying import Uncopied
from doorman.exceptions import BackendError
from doorman.hardware.door import DoorSample, LeafSample
from doorman.ros2 import types as ros
from doorman.ros2.bridge import dds_name, seconds

_IN = Qos(
    Policy.Reliability.BestEffort, Policy.History.KeepLast(1), Policy.DataRepresentation(use_cdrv0_representation=True)
)


class JointStateSource(Uncopied):
    """A `DoorSource`. The constructor joins no network."""

    def __init__(self, topic: str, joint: str = "", domain: int = 0) -> None:
        self._topic, self._joint, self._domain = topic, joint, domain
        self._participant: DomainParticipant | None = None
        self._reader: Any = None
        self._newest = DoorSample()

    def open(self) -> None:
        """Join the network."""
        if self._reader is not None:
            raise BackendError("the source is open already", allowed="stop() before another open()")
        self._newest = DoorSample()
        self._participant = DomainParticipant(self._domain)
        topic = Topic(self._participant, dds_name(self._topic), ros.JointState)
        self._reader = DataReader(self._participant, topic, qos=_IN)

    def read(self) -> DoorSample:
        """What the newest message says."""
        if self._reader is None:
            raise BackendError("the source is not open", allowed="open() before read()")
        for message in self._reader.take(16):
            if isinstance(message, ros.JointState):
                self._newest = DoorSample(self._leaf(message))
        return self._newest

    def stop(self) -> None:
        """Leave the network; may be called twice."""
        self._reader = self._participant = None

    def _leaf(self, message: Any) -> LeafSample:
        names, values = list(message.name), list(message.position)
        place = 0 if not self._joint else names.index(self._joint) if self._joint in names else len(values)
        if place >= len(values):
            raise BackendError("the joint is not in the messages", field="door_sensor.joint", given=self._joint,
                               allowed=", ".join(names) or "a message with a position")  # fmt: skip
        taken = seconds(message.header.stamp)
        age = time.time() - taken if taken > 0.0 else 0.0
        return LeafSample(time.monotonic() - age, float(values[place]))
