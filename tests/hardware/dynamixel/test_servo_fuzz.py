"""Hostile bytes for the servo bus: what cycles do with answers that are damaged, torn, repeated, late or invented.

A scripted line takes the place of the serial port, with a clock of its own, so that time-outs cost nothing. Every input is one
cycle of the bus, and what earlier inputs left behind stays. After each one it is checked that nothing was believed that was not
on the line, that nothing old was passed on as fresh, and that the arm was stopped if anything that matters was wrong.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from doorman.background import EventLog
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.cycle import ServoCommand, ServoCycle
from doorman.hardware.dynamixel.faults import LATCHED, STOPPING
from doorman.hardware.dynamixel.link import Link
from doorman.hardware.dynamixel.monitor import ServoClock
from doorman.hardware.dynamixel.registers import TELEMETRY
from doorman.rig.emulators.servos.packets import HEADER, Instruction, InstructionStream, checksum, status_packet

IDS = (1, 2, 3, 4)
CONFIG = ServoConfig("nowhere", [-3.1] * 4, [3.1] * 4, [1e9] * 4, ids=IDS)
"""Its joints may be anywhere at any time: what is read is judged, not how they move."""
BLOCK = struct.Struct("<iihBBHBBH")
STEPS_ALLOWED = 400
"""Calls of the port that one cycle may make: far more than any honest cycle needs."""
TOLERANCE = 0.004
"""By which the servo's clock of whole milliseconds and its drift may hide that an answer is old [s]."""
AFRESH = 500
"""Cycles after which a bus begins afresh: what is latched would stay for ever."""


class HostileLine:
    """A port whose servos answer, and whose wire does what it likes."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.now, self.calls, self.kind = 1000.0, 0, "honest"
        self.packets: dict[bytes, float] = {}  # when the content of every honest answer was measured
        self.said: dict[int, set[bytes]] = {}  # what whole packets with a right CRC have held in this cycle, by id
        self.history: list[bytes] = []
        self.later: list[bytes] = []
        self._chunks: list[bytes] = []

    def send(self, data: bytes, deadline: float) -> bool:
        self.calls += 1
        for instruction in InstructionStream().feed(data):
            if answers := self._answers(instruction):
                self._put(answers)
        return True

    def receive(self, deadline: float) -> bytes:
        self.calls += 1
        if self._chunks:
            self.now += self.random.uniform(0.0, 3e-4)
            return self._chunks.pop(0)
        self.now = max(self.now, deadline)
        return b""

    def begin(self, kind: str) -> None:
        """Begin a new cycle, with what was late until now at the front."""
        self.kind, self.calls, self.said = kind, 0, {servo_id: set() for servo_id in IDS}
        self.now += self.random.uniform(0.001, 0.004)
        late, self.later = self.later, []
        for packet in late:
            self._note(packet)
        self._chunks += late

    def noise(self, longest: int = 40) -> bytes:
        """Random bytes, or bytes that look like beginnings of packets."""
        alphabet = self.random.choice((range(256), (0xFF, 0xFD, 0x00, 0x55, 0x01, 0x16), HEADER))
        return bytes(self.random.choice(alphabet) for _ in range(self.random.randrange(longest)))

    def _answers(self, instruction: Instruction) -> list[bytes]:
        if instruction.code == 0x82:
            return [self._telemetry(servo_id) for servo_id in instruction.parameters[4:]]
        if instruction.code == 0x02:
            return [self._telemetry(instruction.servo_id)]
        if instruction.code == 0x01:
            return [status_packet(instruction.servo_id, 0, b"\xe8\x03\x2d")]
        return [] if instruction.code == 0x83 else [status_packet(instruction.servo_id, 0)]

    def _telemetry(self, servo_id: int) -> bytes:
        draw = self.random
        block = BLOCK.pack(
            draw.choice((2048, draw.randrange(0, 4096), -1, -3, 0xFDFFFF)), draw.choice((-1, 0, draw.randrange(-130, 130))),
            draw.choice((-1, 0, draw.randrange(-648, 648))), 0, draw.choice((30, 0xFD)) if self.kind == "heat" else 30,
            draw.choice((120, 0xFFFF)), 1, CONFIG.watchdog_counts, int((self.now + servo_id) * 1000.0) % 32768,
        )  # fmt: skip
        self.packets[bytes((servo_id,)) + block] = self.now
        return status_packet(servo_id, 0, block)

    def _put(self, answers: list[bytes]) -> None:
        spoilt = KINDS[self.kind](self, answers)
        self.history = (self.history + answers)[-40:]
        stream = b"".join(spoilt)
        for packet in (*spoilt, stream):
            self._note(packet)
        while stream:
            size = self.random.choice((1, 3, 16, 64, 4096))
            self._chunks.append(stream[:size])
            stream = stream[size:]

    def _note(self, stream: bytes) -> None:
        """Note every whole packet with a right CRC in a stream, wherever it begins: an oracle without a parser's cunning."""
        start = stream.find(HEADER)
        while start >= 0:
            end = start + 7 + int.from_bytes(stream[start + 5 : start + 7], "little")
            packet = stream[start:end]
            whole = len(packet) >= 11 and end <= len(stream)
            if whole and checksum(packet[:-2]) == int.from_bytes(packet[-2:], "little"):
                self.said.setdefault(packet[4], set()).add(packet[9:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd"))
            start = stream.find(HEADER, start + 1)


def flip(line: HostileLine, packets: list[bytes]) -> list[bytes]:
    spoilt = [bytearray(packet) for packet in packets]
    for _ in range(line.random.randint(1, 6)):
        packet = line.random.choice(spoilt)
        packet[line.random.randrange(len(packet))] ^= 1 << line.random.randrange(8)
    return [bytes(packet) for packet in spoilt]


def repeat(line: HostileLine, packets: list[bytes]) -> list[bytes]:
    old = [line.random.choice(line.history) for _ in range(line.random.randint(1, 4))] if line.history else []
    return line.random.choice((old, old + packets, packets + old))


def delay(line: HostileLine, packets: list[bytes]) -> list[bytes]:
    kept = line.random.randrange(len(packets))
    line.later += packets[kept:]
    return packets[:kept]


def lie(line: HostileLine, packets: list[bytes]) -> list[bytes]:
    """Lengths that promise too much or too little."""
    spoilt = [bytearray(packet) for packet in packets]
    length = line.random.choice((0, 1, 3, 4, 60, 200, 0xFFFF, line.random.randrange(65536)))
    line.random.choice(spoilt)[5:7] = length.to_bytes(2, "little")
    return [bytes(packet) for packet in spoilt]


def invent(line: HostileLine, packets: list[bytes]) -> list[bytes]:
    """Whole packets with a right CRC that no honest servo would send."""
    draw = line.random
    size = draw.choice((0, 1, TELEMETRY.size - 1, TELEMETRY.size + 1, 60))
    invented = status_packet(draw.choice((*IDS, 0, 9, 252)), draw.randrange(1, 256), draw.randbytes(size))
    return draw.sample([*packets, invented], len(packets) + 1)


KINDS: dict[str, Callable[[HostileLine, list[bytes]], list[bytes]]] = {
    "honest": lambda line, packets: packets,
    "heat": lambda line, packets: packets,
    "flip": flip,
    "tear": lambda line, packets: [
        one[line.random.choice((0, 0, line.random.randrange(len(one)))) :] for one in packets
    ],
    "cut": lambda line, packets: [
        one[: line.random.choice((len(one), line.random.randrange(len(one))))] for one in packets
    ],
    "lose": lambda line, packets: [packet for packet in packets if line.random.random() < 0.6],
    "repeat": repeat,
    "delay": delay,
    "shuffle": lambda line, packets: line.random.sample(packets, len(packets)),
    "lie": lie,
    "invent": invent,
    "surround": lambda line, packets: [part for packet in packets for part in (line.noise(), packet)] + [line.noise()],
    "noise": lambda line, packets: [line.noise(400)],
    "silence": lambda line, packets: [],
}


def fuzz(inputs: int, seed: int) -> dict[str, int]:
    """Run cycles on hostile lines and check each of them; how often samples were fresh, and the arm was held."""
    counts = {"fresh": 0, "held": 0}
    for start in range(0, inputs, AFRESH):
        line = HostileLine(seed + start)
        link = Link(line, 1_000_000, CONFIG.latency, clock=lambda line=line: line.now)
        ready = tuple(SimpleNamespace(model=1000, velocity_limit=130, current_unit=1.0, turns=0.0) for _ in IDS)
        cycle = ServoCycle(link, ready, CONFIG, EventLog(100))
        for _ in range(5):
            line.begin("honest")
            cycle.listen()
        for _ in range(min(AFRESH, inputs - start)):
            line.begin(line.random.choice(("honest", *KINDS)))
            check(line, cycle, counts)
    return counts


def check(line: HostileLine, cycle: ServoCycle, counts: dict[str, int]) -> None:
    before, began = [monitor.time for monitor in cycle.monitors], line.now
    sample = cycle.step(ServoCommand((0.5, -0.5, 0.3, -0.3), 0.0, line.now, line.now))
    assert line.calls < STEPS_ALLOWED, f"{line.kind}: {line.calls} calls of the port"
    assert line.now - began < 0.2, f"{line.kind}: a cycle of {line.now - began:.3f} s"
    for servo_id, monitor, previous in zip(IDS, cycle.monitors, before, strict=True):
        if monitor.time != previous:
            block = BLOCK.pack(*monitor.telemetry)
            assert block in line.said[servo_id], f"{line.kind}: believed what nobody said"
            old = monitor.time - line.packets.get(bytes((servo_id,)) + block, monitor.time)
            assert old <= TOLERANCE, f"{line.kind}: {old:.4f} s old"
    fresh = sample.at(line.now, CONFIG.stale_after).fresh
    assert fresh == bool(np.min(sample.times) >= line.now - CONFIG.stale_after)
    if sample.fault & (STOPPING | LATCHED):
        assert not sample.goals.any(), f"{line.kind}: {sample.fault} and the arm moves"
        counts["held"] += 1
    counts["fresh"] += fresh


def test_hostile_answers():
    counts = fuzz(2000, seed=20200531)
    assert counts["fresh"] > 500
    assert counts["held"] > 500


@pytest.mark.parametrize(
    ("part", "name", "careless", "told"),
    [
        (ServoClock, "lateness", lambda *arguments: 0.0, "s old"),
        (Link, "_settle", lambda link: None, "believed what nobody said"),
    ],
)
def test_a_careless_adapter_would_be_noticed(monkeypatch, part, name, careless, told):
    monkeypatch.setattr(part, name, careless)
    with pytest.raises(AssertionError, match=told):
        fuzz(2000, seed=1)
