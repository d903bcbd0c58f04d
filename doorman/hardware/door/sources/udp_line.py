"""Readings of the door as lines of text over UDP: for a microcontroller with an encoder, or a shell.

A datagram is one line of `KEY=VALUE` words: `joint=0.52`, and if they are known `deviation=0.002` and `age=0.004`, the seconds
since it was true. A line without `=` is the joint's value alone. `echo 0.52 | nc -u -w0 127.0.0.1 5010` sends one.
"""

from __future__ import annotations

import math
import socket

from doorman.clocks import REAL_TIME, Clock
from doorman.copying import Uncopied
from doorman.exceptions import BackendError
from doorman.hardware.door.sample import DoorSample, LeafSample
from doorman.hardware.mocap.connection import listen

_LARGEST = 1024
"""Longest line [byte]."""
_MOST = 1000
"""Lines that are read at once; more are a flood."""
_KEYS = ("joint", "deviation", "age")


class UdpLineSource(Uncopied):
    """Listens to a port; the newest line counts.

    Args:
        connection: `udp:[HOST:]PORT`; loopback unless a host is written.
        clock: By which lines are stamped.
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
