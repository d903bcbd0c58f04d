"""Hostile datagrams for the mocap receiver: damaged, late, repeated, invented, or somebody else's.

The pipeline behind the socket is fed with a clock of its own, so that waiting costs nothing. Every input is one step of 10 ms on
the wire, and what earlier inputs left behind stays. After each one it is checked that no pose was believed that nobody sent, that
no stamp is newer than the truth, and that nothing old was passed on as fresh. A stranger is nobody, unless the Tracker had been
silent for so long that anybody could take over.
"""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Callable
from itertools import product

import pytest

from doorman.background import EventLog
from doorman.hardware.mocap import MocapConfig, PoseQuality
from doorman.hardware.mocap.faults import MocapFault
from doorman.hardware.mocap.sequence import FrameClock, FrameSequence, Order
from doorman.hardware.mocap.stream import StreamReader
from doorman.hardware.mocap.tracker import Pipeline

NAME = "vehicle"
CONFIG = MocapConfig(NAME)
TRACKER, STRANGER = ("10.0.0.5", 4000), ("10.0.0.66", 4000)
PERIOD = CONFIG.period
TOLERANCE = 0.003
"""By which the jitter of honest packets may hide that a pose is old [s]."""
RESTART = 500
"""Inputs after which the pipeline begins afresh: what delays for ever would hide everything else."""

Packets = list[tuple[bytes, tuple[str, int]]]


class HostileWire:
    """A Tracker that sees a body move, and a wire that does what it likes."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.now = 1000.0
        self.frame = self.random.choice((0, 1, 250_000, 2**32 - 30))
        self.kind = "honest"
        self.taken: dict[tuple[int, ...], float] = {}  # when every pose that the cameras saw was true
        self.said: dict[tuple[int, ...], float] = {}  # when every pose that a datagram holds was on the wire last
        self.open = False  # whether it has been silent, and anybody may have taken over since
        self.delivered: list[bytes] = []  # honest datagrams that arrived
        self.history: list[bytes] = []
        self.late: list[tuple[float, bytes]] = []

    def step(self, kind: str) -> Packets:
        """Datagrams of one step, in the order of their arrival."""
        self.kind = kind
        self.now += PERIOD
        self.frame += 1
        packets = KINDS[kind](self, self._honest())
        due = [datagram for when, datagram in self.late if when <= self.now]
        self.late = [one for one in self.late if one[0] > self.now]
        return [(datagram, TRACKER) for datagram in due] + packets

    def item(self, name: bytes = NAME.encode(), pose: tuple[float, ...] | None = None) -> bytes:
        """An object as the cameras see it now, or with a pose of one's own."""
        if pose is None:
            t = self.now
            noise = [self.random.gauss(0.0, 0.05) for _ in range(3)]
            pose = (300.0 * math.sin(t) + noise[0], 200.0 * math.cos(0.7 * t) + noise[1], 1000.0 + noise[2],
                    0.1 * math.sin(t), 0.1 * math.cos(t), 0.5 * math.sin(0.3 * t))  # fmt: skip
            self.taken[key(*pose[:3])] = t
        return struct.pack("<BH24s6d", 0, 72, name, *pose)

    def packet(self, *items: bytes, number: int | None = None) -> bytes:
        """A datagram of this frame or another."""
        number = self.frame if number is None else number
        return (struct.pack("<IB", number % 2**32, len(items)) + b"".join(items)).ljust(256, b"\0")

    def note(self, datagram: bytes) -> None:
        """Note every pose that a datagram could be said to hold: an oracle without a parser's cunning."""
        if datagram in self.history:
            self.delivered = [*self.delivered[-300:], datagram]
        start = datagram.find(b"\x48\x00")
        while start >= 0:
            place = datagram[start + 26 : start + 50]
            if len(place) == 24:
                values = struct.unpack("<3d", place)
                if all(math.isfinite(value) and abs(value) < 1e9 for value in values):
                    self.said[key(*values)] = self.now
            start = datagram.find(b"\x48\x00", start + 1)

    def _honest(self) -> bytes:
        datagram = self.packet(self.item())
        self.history = [*self.history[-300:], datagram]
        return datagram


def key(*millimetres: float) -> tuple[int, ...]:
    """A place, to a thousandth of a micrometre."""
    return tuple(round(value * 1e6) for value in millimetres)


def mine(*datagrams: bytes) -> Packets:
    return [(datagram, TRACKER) for datagram in datagrams]


def flip(wire: HostileWire, datagram: bytes) -> Packets:
    spoilt = bytearray(datagram)
    for _ in range(wire.random.randint(1, 12)):
        spoilt[wire.random.randrange(5, wire.random.choice((8, 32, 80, 256)))] ^= 1 << wire.random.randrange(8)
    return mine(bytes(spoilt))


def lie(wire: HostileWire, datagram: bytes) -> Packets:
    """Counts, ids and sizes that promise too much or too little."""
    spoilt = bytearray(datagram)
    spoilt[4] = wire.random.choice((0, 1, 2, 3, 4, 255))
    spoilt[5] = wire.random.choice((0, 0, 1, 255))
    spoilt[6:8] = wire.random.choice((0, 1, 71, 72, 73, 75, 200, 65535)).to_bytes(2, "little")
    return mine(bytes(spoilt))


def impossible(wire: HostileWire, datagram: bytes) -> Packets:
    bad = (math.nan, math.inf, -math.inf, 1e300, -1e7, 5e-324)
    pose = [wire.random.choice((*bad, wire.random.uniform(-1e3, 1e3))) for _ in range(6)]
    return mine(wire.packet(wire.item(pose=tuple(pose))))


def stray(wire: HostileWire, datagram: bytes) -> Packets:
    """A number from nowhere."""
    offset = wire.random.choice((-1000, -50, -3, 100, 10_000, 2**31, wire.random.randrange(2**32)))
    return mine(wire.packet(wire.item(), number=wire.frame + offset))


def delay(wire: HostileWire, datagram: bytes) -> Packets:
    wire.late.append((wire.now + wire.random.choice((0.02, 0.04, 0.1, 0.5, 1.5)), datagram))
    return []


def replay(wire: HostileWire, datagram: bytes) -> Packets:
    old = wire.random.choices(wire.history, k=wire.random.randint(1, 5))
    return wire.random.choice((mine(*old), mine(*old, datagram), mine(datagram, *old)))


def freeze(wire: HostileWire, datagram: bytes) -> Packets:
    """An old pose under this frame's number."""
    old = wire.random.choice((wire.delivered[-1], wire.random.choice(wire.delivered)))
    return mine(datagram[:5] + old[5:])


def foreign(wire: HostileWire, datagram: bytes) -> Packets:
    """Somebody else, who sees the body almost where it is."""
    pose = [value + wire.random.uniform(-2.0, 2.0) for value in struct.unpack_from("<6d", datagram, 32)]
    theirs = wire.packet(wire.item(pose=(*pose[:3], 0.0, 0.0, 0.0)))
    return [(theirs, STRANGER)] * wire.random.randint(1, 3) + mine(datagram)


def blocks(wire: HostileWire, datagram: bytes) -> Packets:
    others = [wire.packet(wire.item(b"wand", (1.0, 2.0, 3.0, 0.1, 0.2, 0.3))) for _ in range(wire.random.randint(1, 3))]
    return wire.random.sample(mine(datagram, *others), len(others) + 1)


def twins(wire: HostileWire, datagram: bytes) -> Packets:
    return mine(wire.packet(wire.item(), wire.item(pose=(9e2, 9e2, 9e2, 0.0, 0.0, 0.0))))


def names(wire: HostileWire, datagram: bytes) -> Packets:
    names = (b"", b"vehicle2", b"Vehicle", b"\xff" * 24, b"v\0ehicle", b"wand")
    return mine(wire.packet(wire.item(wire.random.choice(names))))


def noise(wire: HostileWire, datagram: bytes) -> Packets:
    sizes = (0, 1, 4, 5, 7, 8, 79, 80, 81, 300)
    return mine(*(wire.random.randbytes(wire.random.choice(sizes)) for _ in range(wire.random.randint(1, 4))))


KINDS: dict[str, Callable[[HostileWire, bytes], Packets]] = {
    "honest": lambda wire, datagram: mine(datagram),
    "lose": lambda wire, datagram: [],
    "twice": lambda wire, datagram: mine(datagram, datagram),
    "cut": lambda wire, datagram: mine(datagram[: wire.random.randrange(len(datagram))]),
    "longer": lambda wire, datagram: mine(datagram + wire.random.randbytes(100)),
    "zeros": lambda wire, datagram: mine(wire.packet(wire.item(pose=(0.0,) * 6))),
    "wild": lambda wire, datagram: mine(wire.packet(wire.item(pose=tuple(wire.random.uniform(-4e3, 4e3) for _ in "xyz")
                                                               + (0.0, 0.0, 0.0)))),
    "flip": flip,
    "lie": lie,
    "impossible": impossible,
    "stray": stray,
    "delay": delay,
    "replay": replay,
    "freeze": freeze,
    "foreign": foreign,
    "blocks": blocks,
    "twins": twins,
    "names": names,
    "noise": noise,
}  # fmt: skip


def fuzz(inputs: int, seed: int) -> dict[str, int]:
    """Feed pipelines with hostile wires and check each step; how often every quality was seen."""
    counts = {quality.name: 0 for quality in PoseQuality}
    for start in range(0, inputs, RESTART):
        wire, pipeline = HostileWire(seed + start), Pipeline(CONFIG, EventLog(100))
        for _ in range(50):
            step(wire, pipeline, "honest", counts)
        kinds = [*KINDS, *["honest"] * wire.random.choice((1, 5, 20, 60))]
        spell = "honest"
        for _ in range(min(RESTART, inputs - start)):
            if wire.random.random() < 0.3:  # some troubles last
                spell = wire.random.choice(kinds)
            step(wire, pipeline, spell, counts)
    return counts


def step(wire: HostileWire, pipeline: Pipeline, kind: str, counts: dict[str, int]) -> None:
    packets = wire.step(kind)
    lateness = sorted(wire.random.uniform(0.0, 1e-3) for _ in packets)
    for (datagram, sender), late in zip(packets, lateness, strict=True):
        arrival = wire.now + CONFIG.latency + late
        wire.open = wire.open or MocapFault.SILENT in pipeline.book.holds
        if sender is TRACKER or wire.open:
            wire.note(datagram)
        pipeline.feed(datagram, sender, arrival, arrival)
        check(wire, pipeline, arrival, counts)
    later = wire.now + CONFIG.latency + wire.random.uniform(1e-3, PERIOD - 1e-3)
    pipeline.tick(later)
    check(wire, pipeline, later, counts)


NEIGHBOURS = list(product((-1, 0, 1), repeat=3))


def check(wire: HostileWire, pipeline: Pipeline, now: float, counts: dict[str, int]) -> None:
    measurement = pipeline.latest
    sample = pipeline.at(now)
    counts[sample.quality.name] += 1
    assert sample.fresh == (sample.quality is PoseQuality.MEASURED)
    if measurement.count == 0:
        return
    assert all(map(math.isfinite, (*sample.position, *sample.attitude, *sample.velocity, *sample.body_rates)))
    place = key(*(1e3 * value for value in measurement.position.tolist()))
    near = [tuple(a + b for a, b in zip(place, shift, strict=True)) for shift in NEIGHBOURS]
    said = [wire.said[one] for one in near if one in wire.said]
    assert said, f"{wire.kind}: believed what nobody said: {measurement.position}"
    taken = [wire.taken[one] for one in near if one in wire.taken]
    if taken:
        assert measurement.time <= max(taken) + TOLERANCE, (
            f"{wire.kind}: stamped {measurement.time - max(taken):.4f} s too new"
        )
    if sample.fresh:
        old = now - max(taken or said)
        assert old <= CONFIG.stale_after + TOLERANCE, f"{wire.kind}: {old:.4f} s old and called fresh"


def test_hostile_datagrams():
    counts = fuzz(1500, seed=20200531)
    assert counts["MEASURED"] > 1000
    assert counts["PREDICTED"] > 100
    assert counts["LOST"] > 100


CLASSIFY = FrameSequence.classify


def takes_late_ones(sequence, number, arrival):
    order = CLASSIFY(sequence, number, arrival)
    return Order.SAME if order is Order.LATE else order


@pytest.mark.parametrize(
    ("part", "name", "careless", "told"),
    [
        (FrameClock, "time_of", lambda clock, frame, arrival: arrival - 0.005, "too new"),
        (StreamReader, "_unseen", lambda reader, found: True, "too new"),
        (StreamReader, "_welcome", lambda reader, sender: True, "believed what nobody said"),
        (FrameSequence, "classify", takes_late_ones, "too new"),
    ],
)
def test_a_careless_adapter_would_be_noticed(monkeypatch, part, name, careless, told):
    monkeypatch.setattr(part, name, careless)
    with pytest.raises(AssertionError, match=told):
        fuzz(4000, seed=1)
