"""An emulated OptiTrack Motive: NatNet over UDP, unicast, with the handshake of its command port.

Packets are little endian: message (uint16), size of what follows (uint16), content. A client sends CONNECT and gets the server's
version and data port; REQUEST_MODELDEF brings the names of the bodies; frames go to the data port. From version 4.1 on, each list
of a frame begins with its size in bytes.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from doorman.background import InThread
from doorman.checks import vector
from doorman.rig.emulators.mocap.emulator import BodyPose

CONNECT, SERVER_INFO, REQUEST_MODELDEF, MODELDEF, FRAME = 0, 1, 4, 5, 7
TICKS = 10_000_000
"""Ticks of the high-resolution clock in a second [1/s]."""
_HEADER = struct.Struct("<HH")
_INFO = struct.Struct("<256s4B4BQH?4B")
_BODY = struct.Struct("<i3f4ffh")
_TRACKED = 1


@dataclass
class NatNetBody:
    name: str
    number: int  # streaming id
    pose: Callable[[float], BodyPose]  # by time, in Motive's axes [s]
    tracked: bool = True  # whether the cameras see it


def server_info(version: tuple[int, int], data_port: int) -> bytes:
    content = _INFO.pack(b"Motive", 3, 0, 0, 0, *version, 0, 0, TICKS, data_port, False, 0, 0, 0, 0)
    return _HEADER.pack(SERVER_INFO, len(content)) + content


def model_definition(bodies: Sequence[NatNetBody], version: tuple[int, int]) -> bytes:
    """Answer to REQUEST_MODELDEF: names and streaming ids of the bodies, without markers."""
    content = struct.pack("<i", len(bodies))
    for body in bodies:
        described = body.name.encode() + b"\0" + struct.pack("<ii3fi", body.number, -1, 0.0, 0.0, 0.0, 0)
        size = struct.pack("<i", len(described)) if version >= (4, 1) else b""
        content += struct.pack("<i", 1) + size + described
    return _HEADER.pack(MODELDEF, len(content)) + content


def frame(number: int, bodies: Sequence[NatNetBody], at: float, version: tuple[int, int]) -> bytes:

    def counted(count: int, items: bytes) -> bytes:
        size = struct.pack("<i", len(items)) if version >= (4, 1) else b""
        return struct.pack("<i", count) + size + items

    seen = b"".join(_body(body, at) for body in bodies)
    lists = counted(0, b"") + counted(0, b"") + counted(len(bodies), seen) + counted(0, b"")
    lists += counted(0, b"") if version >= (4, 1) else b""  # assets
    lists += counted(0, b"") + counted(0, b"") + counted(0, b"")
    ticks = round(at * TICKS)
    content = struct.pack("<i", number) + lists + struct.pack("<iid3Qhi", 0, 0, at, ticks, ticks, ticks, 0, 0)
    return _HEADER.pack(FRAME, len(content)) + content


def _body(body: NatNetBody, at: float) -> bytes:
    pose = body.pose(at)
    place, (w, x, y, z) = vector(pose.position, 3, "position"), vector(pose.quaternion, 4, "quaternion")
    return _BODY.pack(body.number, *place, x, y, z, w, 1e-4, _TRACKED if body.tracked else 0)


class NatNetEmulator(InThread):
    """Motive that exists only in software. The constructor opens nothing."""

    def __init__(
        self, bodies: Sequence[NatNetBody], command_port: int, data_port: int, rate: float = 100.0,
        version: tuple[int, int] = (4, 1),
    ) -> None:  # fmt: skip
        super().__init__("emulated Motive")
        self.bodies = list(bodies)
        self.silent = False  # whether no frames are sent
        self._ports, self._period, self._version = (command_port, data_port), 1.0 / rate, version

    def _run(self) -> None:
        number, due = 0, self._clock.now()
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as commands,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as frames,
        ):
            commands.bind(("127.0.0.1", self._ports[0]))
            while not self._stopping.is_set():
                if self._clock.readable([commands], max(due - self._clock.now(), 0.0)):
                    self._answer(commands)
                elif self._clock.now() >= due:
                    number += 1
                    if not self.silent:
                        frames.sendto(frame(number, self.bodies, due, self._version), ("127.0.0.1", self._ports[1]))
                    due += self._period

    def _answer(self, channel: socket.socket) -> None:
        request, sender = channel.recvfrom(1024)
        message = _HEADER.unpack_from(request)[0]
        if message == CONNECT:
            channel.sendto(server_info(self._version, self._ports[1]), sender)
        elif message == REQUEST_MODELDEF:
            channel.sendto(model_definition(self.bodies, self._version), sender)
