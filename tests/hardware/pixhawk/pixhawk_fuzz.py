"""Fuzzes everything that reads from the autopilot: run `python tests/hardware/pixhawk/pixhawk_fuzz.py 100000`.

Inputs are damaged, cut, joined and invented packets, and valid packets with absurd figures. For each: nothing is raised, the
memory stays bounded, and no state is passed on that did not come in a valid message of the vehicle.
"""

from __future__ import annotations

import math
import random
import struct
import sys
import time
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.pixhawk import PixhawkConfig
from doorman.hardware.pixhawk.link.inbox import WANTED
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.wire.codec import Codec

_EDGE_FLOATS = (0.0, -0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-45, 1e10)
_STRUCT_INTEGERS = {"B": 8, "b": -8, "H": 16, "h": -16, "I": 32, "i": -32, "Q": 64, "q": -64}


class Nobody:
    """A line that takes everything and gives nothing."""

    peer = ("127.0.0.1", 9)
    busy = False

    def send(self, data: bytes) -> bool:
        return True


class Fuzzer:
    """Makes inputs and feeds them to a link without a thread or a device.

    Args:
        seed: Of the inputs.
    """

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.link = Link(PixhawkConfig("udp:14540"))
        self.link.codec = Codec(255, 190, None, WANTED)
        self.line: Any = Nobody()
        self.vehicle = mavlink.MAVLink(None, 1, 1)
        self.kinds = [mavlink.mavlink_map[identifier] for identifier in sorted(WANTED)]
        self.feed(mavlink.MAVLink_heartbeat_message(13, 12, 81, 4 << 16, 3, 3).pack(self.vehicle))

    def feed(self, data: bytes) -> None:
        """Give bytes to the link, as its thread does."""
        self.link.receive(data, self.line.peer, self.line)

    def once(self) -> None:
        """One input, and what must hold after it."""
        self.feed(self.random.choice((self.noise, self.damaged, self.cut, self.absurd, self.joined))())
        if self.random.random() < 0.05:
            self.link._watch(time.monotonic())
            self.link._send_due(self.line, time.monotonic())
        self.check()

    def check(self) -> None:
        sample = self.link.tracker.sample
        for values in (sample.position, sample.velocity, sample.attitude, sample.body_rates):
            known = [value for value in values.tolist() if not math.isnan(value)]
            assert len(known) in (0, len(values)) and all(abs(value) <= 1e6 for value in known), values
        assert sample.attitude_time <= time.monotonic() and sample.position_time <= time.monotonic()
        assert len(self.link._texts._parts) <= 8
        for splitter in self.link.codec._splitters.values():  # type: ignore[union-attr]
            assert len(splitter._buffer) < 300

    def noise(self) -> bytes:
        return self.random.randbytes(self.random.randint(0, 300))

    def damaged(self) -> bytes:
        data = bytearray(self.absurd())
        for _ in range(self.random.randint(1, 5)):
            data[self.random.randrange(len(data))] = self.random.randrange(256)
        return bytes(data)

    def cut(self) -> bytes:
        data = self.absurd()
        return data[: self.random.randint(1, len(data))]

    def joined(self) -> bytes:
        return b"".join(self.absurd() if self.random.random() < 0.7 else self.noise() for _ in range(3))

    def absurd(self) -> bytes:
        """A packet with a right checksum and any figures at all."""
        kind = self.random.choice(self.kinds)
        message = kind(*(self._argument(kind, name) for name in kind.fieldnames))
        sender = self.vehicle if self.random.random() < 0.9 else mavlink.MAVLink(None, self.random.randint(0, 255), 1)
        sender.seq = self.random.randrange(256)
        return bytes(message.pack(sender, force_mavlink1=self.random.random() < 0.1 and kind.id < 256))

    def _argument(self, kind: Any, name: str) -> Any:
        place = kind.ordered_fieldnames.index(name)
        code = kind.native_format.decode().lstrip("<")[place]
        length = kind.array_lengths[place]
        if code == "c":
            return self.random.randbytes(self.random.randint(0, length))
        return [self._field(code) for _ in range(length)] if length else self._field(code)

    def _field(self, code: str) -> Any:
        if code in "fd":
            value = self.random.choice((*_EDGE_FLOATS, self.random.uniform(-100.0, 100.0)))
            return struct.unpack("<f", struct.pack("<f", value))[0]
        bits = _STRUCT_INTEGERS[code]
        low, high = (0, 2**bits - 1) if bits > 0 else (-(2 ** (-bits - 1)), 2 ** (-bits - 1) - 1)
        return self.random.choice((low, high, 0, 1, self.random.randint(low, high)))


def main() -> None:
    """Fuzz with as many inputs as the first argument says, from the seed of the second."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    fuzzer = Fuzzer(int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    longest = 0.0
    started = time.monotonic()
    for _ in range(count):
        before = time.monotonic()
        fuzzer.once()
        longest = max(longest, time.monotonic() - before)
    counters = fuzzer.link.codec.counters  # type: ignore[union-attr]
    print(f"{count} inputs in {time.monotonic() - started:.1f} s, the longest took {1e3 * longest:.1f} ms: {counters}")


if __name__ == "__main__":
    main()
