"""Feed: what a flight records, as datagrams to a bridge on this computer.

The flight's thread copies a message into one datagram and goes on; a bridge that is slow, or not there, costs it nothing.
"""

from __future__ import annotations

import json
import socket
import time as clock
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import orjson

from doorman.copying import Uncopied
from doorman.recording.files.messages import Value

PORT = 51_100
"""Of the bridge, on loopback."""
LARGEST = 65_000
"""Of a datagram [byte]."""
BUFFER = 1 << 22
"""Of the bridge's socket: some seconds of a flight [byte]."""
FED = {
    "measurement": ("position", "velocity", "attitude", "body_rates", "arm_angles", "arm_rates"),
    "estimate": ("state", "tip_force"),
    "plan": ("states",),
    "mission": ("state", "message"),
}
"""Fields that the bridge reads, by topic."""


class FedMessage(NamedTuple):
    """One message of a flight."""

    topic: str
    wall_time: int
    """When it was recorded, since 1970 [ns]."""
    fields: Mapping[str, Any]
    """Numbers, texts, and arrays; of arrays NaN stays NaN."""


class Feed(Uncopied):
    """Sends what a recorder is given; its `listen` is the recorder's listener.

    Args:
        port: Of the bridge, on loopback.
    """

    def __init__(self, port: int = PORT) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._socket.setblocking(False)
        self.unsent = 0
        """Messages that nobody took."""

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
        data = orjson.dumps([topic, clock.time_ns(), chosen])
        try:
            self._socket.send(data)
        except OSError:  # nobody listens, or its buffer is full
            self.unsent += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def __enter__(self) -> Feed:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def parse(datagram: bytes) -> FedMessage | None:
    """What `Feed` has sent; None for anything else.

    Args:
        datagram: As received.
    """
    try:
        topic, wall_time, fields = json.loads(datagram)
        read = {name: _array(fields[name]) for name in FED[topic]}
        return FedMessage(topic, int(wall_time), read)
    except (ValueError, KeyError, TypeError):
        return None


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _array(value: Any) -> Any:
    """Lists as arrays of floats; JSON's null, which stands for NaN, as NaN."""
    return np.array(value, dtype=np.float64) if isinstance(value, list) else value
