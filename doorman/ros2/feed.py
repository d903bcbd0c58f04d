"""Feed: what a flight records, as datagrams to a bridge on this computer.

The flight's thread copies a message into one datagram and goes on; a bridge that is slow, or not there, costs it nothing.
"""

from __future__ import annotations

import math
import socket
import time as clock
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import orjson

from doorman.background import Closed
from doorman.recording.files.messages import Value

PORT = 51_100
"""UDP port of the bridge, on loopback."""
LARGEST = 65_000
"""Largest datagram [byte]."""
BUFFER = 1 << 22
"""Receive buffer of the bridge's socket: some seconds of a flight [byte]."""
TEXT, NUMBER = 0, -1
FED: dict[str, dict[str, int]] = {
    "truth": {},
    "measurement": {"position": 1, "velocity": 1, "attitude": 1, "body_rates": 1, "arm_angles": 1, "arm_rates": 1},
    "estimate": {"state": 1, "tip_force": 1},
    "plan": {"states": 2},
    "door_sensor": {"joint": NUMBER, "deviation": NUMBER},
    "mission": {"state": TEXT, "message": TEXT},
}
"""Fields that the bridge reads, by topic: texts, numbers, and dimensions of arrays. A truth says that time is simulated."""
_END_OF_TIME = 2**31 * 1_000_000_000
"""First time that ROS cannot hold [ns]."""


class FedMessage(NamedTuple):
    """One message of a flight."""

    topic: str
    wall_time: int  # when it was recorded, since 1970 [ns]
    fields: Mapping[str, Any]  # numbers, texts, and arrays; of arrays NaN stays NaN
    time: float = 0.0  # since the flight's backend was opened [s]


class Feed(Closed):
    """Sends what a recorder is given; its `listen` is the recorder's listener.

    Args:
        port: Of the bridge, on loopback.
    """

    def __init__(self, port: int = PORT) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._socket.setblocking(False)
        self.unsent = 0
        """Messages that the bridge did not take."""

    def listen(self, topic: str, time: float, fields: Mapping[str, Value]) -> None:
        """Send one message, if the bridge reads its topic; never waits.

        Args:
            topic: Of the recording.
            time: Of the message [s].
            fields: By name.
        """
        if topic not in FED:
            return
        chosen = {name: _plain(fields[name]) for name in FED[topic]}
        data = orjson.dumps([topic, clock.time_ns(), chosen, float(time)])
        try:
            self._socket.send(data)
        except OSError:  # no bridge, or its buffer is full
            self.unsent += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def parse(datagram: bytes) -> FedMessage | None:
    """What `Feed` has sent; None for anything else."""
    try:
        topic, wall_time, fields, time = orjson.loads(datagram)
        read = {name: _value(fields[name], dimensions) for name, dimensions in FED[topic].items()}
    except (ValueError, KeyError, TypeError):
        return None
    if type(wall_time) is not int or type(time) is not float:
        return None
    if not all(0 <= at < _END_OF_TIME for at in (wall_time, 1e9 * time)):
        return None
    return FedMessage(topic, wall_time, read, time)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _value(value: Any, dimensions: int) -> Any:
    """A text, or lists of numbers as an array of floats; JSON's null, which stands for NaN, as NaN."""
    if dimensions == TEXT:
        if not isinstance(value, str):
            raise TypeError
        return value
    if dimensions == NUMBER:
        return _floats(value, 0)
    return np.array(_floats(value, dimensions))


def _floats(value: Any, depth: int) -> Any:
    if depth:
        return [_floats(one, depth - 1) for one in value]
    if value is not None and type(value) not in (int, float):
        raise TypeError
    return math.nan if value is None else float(value)
