"""The bridge: a DDS participant that publishes a flight to ROS 2, and takes poses from there to the receiver of cameras."""

from __future__ import annotations

import select
import socket
import time
from collections import Counter
from typing import Any

from cyclonedds.core import DDSException, InstanceState, Policy, Qos, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from doorman.background import Closed
from doorman.clocks import LONGEST_WAIT
from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapFault
from doorman.model import Model
from doorman.ros2 import types as ros
from doorman.ros2.feed import BUFFER, LARGEST, PORT, parse
from doorman.ros2.messages import Outgoing, Translator
from doorman.ros2.relay import PoseRelay
from doorman.ros2.topics import TOPICS

_DEPTH = 100
"""Messages that a slow subscriber may be behind."""
_PLAIN = Policy.DataRepresentation(use_cdrv0_representation=True)
"""CDR as ROS 2 has it."""
_OUT = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(_DEPTH), _PLAIN)
_LATCHED = Qos(
    Policy.Reliability.Reliable(duration(milliseconds=100)),
    Policy.History.KeepLast(1),
    Policy.Durability.TransientLocal,
    _PLAIN,
)
"""Keeps the last message for subscribers that come late."""
_IN = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(_DEPTH), _PLAIN)
"""Takes poses of reliable and of best-effort publishers."""


def dds_name(topic: str) -> str:
    """Name under which DDS knows a topic of ROS."""
    return f"rt/{topic.strip('/')}"


def seconds(stamp: Any) -> float:
    """Time of a stamp [s]; 0 of one that is not set."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


class FlightPublisher(Closed):
    """Publishes what a `Feed` sends."""

    def __init__(self, model: Model, port: int = PORT, domain: int = 0, prefix: str = "doorman") -> None:
        self._translator = Translator(model)
        self._participant = DomainParticipant(domain)
        self._writers: dict[str, Any] = {}
        for topic in TOPICS:
            dds = Topic(self._participant, dds_name(topic.under(prefix)), topic.type)
            quality = _LATCHED if topic.latched else _OUT
            self._writers[topic.name] = DataWriter(self._participant, dds, qos=quality)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
        try:
            self._socket.bind(("127.0.0.1", port))
        except OSError as error:
            self._socket.close()
            raise BackendError(
                f"cannot listen: {error.strerror}", field="port", given=port, allowed="a free port"
            ) from error
        for message in self._translator.at_the_start():
            self._write(message)
        self.port = int(self._socket.getsockname()[1])  # of the feed
        self.published = 0  # messages of the flight
        self.refusals: Counter[str] = Counter()  # what was left out, by its reason

    def step(self, timeout: float = LONGEST_WAIT) -> None:
        """Publish what has come."""
        if not select.select([self._socket], [], [], timeout)[0]:
            return
        fed = parse(self._socket.recv(LARGEST))
        if fed is None:
            self.refusals["no message of a flight"] += 1
            return
        try:
            for message in self._translator.translate(fed):
                self._write(message)
        except BackendError as error:
            self.refusals[f"{error.field}: {error.message}"] += 1
        except DDSException as error:
            if error.code != DDSException.DDS_RETCODE_TIMEOUT:
                raise
            self.refusals["a reliable subscriber does not keep up"] += 1
        else:
            self.published += 1

    def close(self) -> None:
        self._socket.close()
        self._participant = None
        self._writers.clear()

    def _write(self, message: Outgoing) -> None:
        self._writers[message.topic].write(message.message)


class PoseSubscriber(Closed):
    """Takes `geometry_msgs/PoseStamped` of one publisher and sends them on as a stream of cameras, see `PoseRelay`."""

    def __init__(self, topic: str, name: str, target: tuple[str, int], rate: float, domain: int = 0) -> None:
        self.relay = PoseRelay(name, target, rate)
        self._participant = DomainParticipant(domain)
        self._reader = DataReader(
            self._participant, Topic(self._participant, dds_name(topic), ros.PoseStamped), qos=_IN
        )
        self._waiting = WaitSet(self._participant)
        condition = ReadCondition(self._reader, SampleState.NotRead | ViewState.Any | InstanceState.Any)
        self._waiting.attach(condition)

    def step(self, timeout: float = LONGEST_WAIT) -> None:
        """Send on what has come."""
        self._waiting.wait(duration(seconds=timeout))
        for _ in range(_DEPTH):
            try:
                samples = self._reader.take()
            except DDSException:
                raise
            except Exception as error:  # whatever a stranger's bytes make of the parser; the sample is taken
                self.relay.refuse(MocapFault.CORRUPT, time.monotonic(), f"no PoseStamped: {error}")
                continue
            if not samples:
                break
            if isinstance(sample := samples[0], ros.PoseStamped):
                taken, place, turn = seconds(sample.header.stamp), sample.pose.position, sample.pose.orientation
                self.relay.take(
                    sample.sample_info.publication_handle, (place.x, place.y, place.z), (turn.w, turn.x, turn.y, turn.z),
                    taken if taken > 0.0 else None, time.monotonic(),
                )  # fmt: skip
        self.relay.tick(time.monotonic())

    def close(self) -> None:
        self.relay.close()
        self._reader = self._waiting = self._participant = None
