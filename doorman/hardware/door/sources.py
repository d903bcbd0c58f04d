"""Sources of the door's readings: objects of the cameras that see the vehicle, and lines of text over UDP.

A datagram is one line of `KEY=VALUE` words: `joint=0.52`, and if they are known `deviation=0.002` and `age=0.004`, the seconds
since it was true. A line without `=` is the joint's value alone. `echo 0.52 | nc -u -w0 127.0.0.1 5010` sends one.
"""

from __future__ import annotations

import math
import socket
from dataclasses import replace

from doorman.clocks import REAL_TIME, Clock
from doorman.copying import Uncopied
from doorman.door_sensor.config import CAMERAS, TAGS, DoorSensorConfig
from doorman.door_sensor.sensor import CallableSource, DoorSample, DoorSource, FrameSample, LeafSample, MarkPose
from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapConfig, MocapReceiver
from doorman.hardware.mocap.connection import listen


def objects_beside(cameras: MocapConfig, sensor: DoorSensorConfig | None) -> dict[str, MocapConfig]:
    """Further objects that a receiver follows, by `leaf` and `frame`."""
    if sensor is None or sensor.source != CAMERAS:
        return {}
    return {
        part: replace(
            cameras, object_name=mark.name, object_position=mark.position, object_attitude=mark.attitude,
        )
        for part, mark in sensor.marks.items()
    }  # fmt: skip


def camera_objects(receiver: MocapReceiver) -> DoorSource:
    """What a receiver sees of the door: newest poses of both; one that is not fresh is none. Who flies by it opens it."""

    def pose(part: str) -> tuple[float, MarkPose] | None:
        if part not in receiver.beside or not (sample := receiver.read_beside(part)).fresh:
            return None
        (x, y, z), (w, qx, qy, qz) = sample.position.tolist(), sample.quaternion.tolist()
        return sample.time, MarkPose((x, y, z), (w, qx, qy, qz))

    def read() -> DoorSample:
        leaf, frame = pose("leaf"), pose("frame")
        return DoorSample(
            None if leaf is None else LeafSample(leaf[0], pose=leaf[1]), None if frame is None else FrameSample(*frame)
        )

    return CallableSource(read)


_LARGEST = 1024
"""Longest line [byte]."""
_MOST = 1000
"""Lines that are read at once; more are a flood."""
_KEYS = ("joint", "deviation", "age")


class UdpLineSource(Uncopied):
    """Listens to a port; the newest line counts.

    Args:
        connection: `udp:[HOST:]PORT`; loopback unless a host is written.
        clock: Clock of the lines' stamps.
    """

    def __init__(self, connection: str, clock: Clock = REAL_TIME) -> None:
        self._connection, self._clock = connection, clock
        self._channel: socket.socket | None = None
        self._newest = DoorSample()

    def open(self) -> None:
        """Listen.

        Raises:
            BackendError: if the address cannot be listened on, or it is open already.
        """
        if self._channel is not None:
            raise BackendError("the source is open already", allowed="stop() before another open()")
        self._newest = DoorSample()
        self._channel = listen(self._connection)

    def read(self) -> DoorSample:
        """What the newest line says.

        Raises:
            BackendError: if it is not open, or the newest line cannot be read.
        """
        if self._channel is None:
            raise BackendError("the source is not open", allowed="open() before read()")
        line = b""
        for _ in range(_MOST):
            try:
                line = self._channel.recv(_LARGEST)
            except BlockingIOError:
                break
        if line:
            self._newest = DoorSample(self._parsed(line))
        return self._newest

    def stop(self) -> None:
        """Close the socket; may be called twice."""
        channel, self._channel = self._channel, None
        if channel is not None:
            channel.close()

    def _parsed(self, line: bytes) -> LeafSample:
        text = line.decode(errors="replace").strip()
        words = dict(word.partition("=")[::2] for word in text.split()) if "=" in text else {"joint": text}
        try:
            values = {name: float(value) for name, value in words.items()}
        except ValueError:
            values = {}
        if "joint" not in values or not set(values) <= set(_KEYS) or not all(map(math.isfinite, values.values())):
            raise BackendError(
                "not a line of the door", field="door_sensor.source", given=text[:60], allowed="joint=0.52"
            )
        return LeafSample(
            self._clock.now() - values.get("age", 0.0), values["joint"], deviation=values.get("deviation")
        )


def source_of(config: DoorSensorConfig, cameras: MocapReceiver | None, clock: Clock = REAL_TIME) -> DoorSource:
    """The source of a configuration; it is not open."""
    if config.source == CAMERAS:
        if cameras is None:
            raise BackendError(
                "there are no cameras", field="door_sensor.source", given=CAMERAS, allowed="another source"
            )
        return camera_objects(cameras)
    if config.source == TAGS:
        from doorman.hardware.door.tags import TagSource

        return TagSource(config)
    if config.source.startswith("udp:"):
        return UdpLineSource(config.source, clock)
    raise BackendError("the program has to hand on the source", field="door_sensor.source", given=config.source,
                       allowed="VehicleLinks(door=...); doorman fly makes that of a ROS 2 topic itself")  # fmt: skip
