"""The emulated autopilot's line: UDP on loopback with the faults of a bad link, and its clock against the companion's."""

from __future__ import annotations

import contextlib
import heapq
import itertools
import math
import random
import socket
from dataclasses import dataclass

from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError


@dataclass
class LinkFaults:
    """Faults in one direction; probabilities a message. May be changed at any time."""

    loss: float = 0.0
    duplicate: float = 0.0
    reorder: float = 0.0
    corrupt: float = 0.0  # one to four bytes are changed
    delay: float = 0.0  # [s]
    cut: bool = False  # nothing passes


class FaultyUdp:
    """A UDP socket on loopback that loses, doubles, swaps, damages and delays what passes."""

    def __init__(
        self, local: tuple[str, int], remote: tuple[str, int] | None, faults: tuple[LinkFaults, LinkFaults], seed: int,
        time: Clock = REAL_TIME,
    ) -> None:  # fmt: skip
        if not local[0].startswith("127.") or (remote is not None and not remote[0].startswith("127.")):
            raise BackendError("emulators stay on loopback", field="address", given=local[0], allowed="127.0.0.0/8")
        self._outgoing, self._incoming = faults
        self._time = time
        self._remote = remote
        self._random = random.Random(seed)
        self._held: dict[int, bytes] = {}  # the message that waits for the next one, by its direction
        self._waiting: list[tuple[float, int, bytes]] = []
        self._ticket = itertools.count()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(local)
            self._socket.setblocking(False)
        except OSError as error:
            self._socket.close()
            raise BackendError(f"cannot be bound: {error}", field="address", given=f"{local[0]}:{local[1]}") from error

    @property
    def address(self) -> tuple[str, int]:
        host, port = self._socket.getsockname()
        return str(host), int(port)

    def wait(self, timeout: float) -> None:
        self._time.readable([self._socket], max(0.0, timeout))

    def receive(self) -> list[bytes]:
        datagrams: list[bytes] = []
        for _ in range(64):
            try:
                data, sender = self._socket.recvfrom(65536)
            except (BlockingIOError, ConnectionError):
                break
            self._remote = self._remote or (sender[0], sender[1])
            datagrams += self._suffer(data, self._incoming)
        return datagrams

    def send(self, data: bytes) -> None:
        for piece in self._suffer(data, self._outgoing):
            heapq.heappush(self._waiting, (self._time.now() + self._outgoing.delay, next(self._ticket), piece))
        self.flush()

    def flush(self) -> None:
        while self._waiting and self._waiting[0][0] <= self._time.now():
            piece = heapq.heappop(self._waiting)[2]
            if self._remote is not None:
                with contextlib.suppress(BlockingIOError, ConnectionError):
                    self._socket.sendto(piece, self._remote)

    def close(self) -> None:
        self._socket.close()

    def _suffer(self, data: bytes, faults: LinkFaults) -> list[bytes]:
        chance = self._random.random
        if faults.cut or chance() < faults.loss:
            return []
        if chance() < faults.corrupt:
            damaged = bytearray(data)
            for _ in range(self._random.randint(1, 4)):
                damaged[self._random.randrange(len(damaged))] ^= self._random.randint(1, 255)
            data = bytes(damaged)
        pieces = [data, data] if chance() < faults.duplicate else [data]
        held = self._held.pop(id(faults), None)
        if held is not None:
            return [*pieces, held]
        if chance() < faults.reorder:
            self._held[id(faults)] = data
            return pieces[1:]
        return pieces


_ANSWERS_NEEDED = 20
"""Answers to TIMESYNC before PX4 trusts its mapping."""


class BootClock:
    boot = 3.0  # its reading when the link comes up [s]

    def __init__(self, pace: float = 1.0, time: Clock = REAL_TIME) -> None:
        self.jumped = 0.0  # by which it has jumped since boot; may be set at any time [s]
        self._pace, self._time, self._started = pace, time, time.now()

    @property
    def uptime(self) -> float:
        """Since boot, by which it counts its own time-outs: that never jumps [s]."""
        return self.boot + (self._time.now() - self._started) * self._pace

    @property
    def now(self) -> float:
        """What its messages are stamped with [s]."""
        return self.uptime + self.jumped


class CompanionClock:
    """Maps stamps of a companion to the autopilot's clock, the way the two autopilots do it."""

    def __init__(self, by_timesync: bool) -> None:
        self.answers, self.offset = 0, 0.0  # answers so far, and the autopilot's clock minus the companion's [s]
        self._by_timesync, self._least = by_timesync, math.inf

    def answer(self, sent_ns: int, companion_ns: int, now_ns: int) -> None:
        offset = ((sent_ns + now_ns) / 2 - companion_ns) * 1e-9
        self.offset = offset if self.answers == 0 else 0.8 * self.offset + 0.2 * offset
        self.answers += 1

    def stamp(self, companion_us: int, now: float) -> float:
        """Time of a companion's stamp on the autopilot's clock [s]."""
        stamp = companion_us * 1e-6
        if self._by_timesync:
            return stamp + self.offset if self.answers >= _ANSWERS_NEEDED else now
        self._least = min(self._least + 1e-5, now - stamp)
        return stamp + self._least
