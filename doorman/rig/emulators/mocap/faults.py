"""Faults of an emulated stream of poses: of cameras, Tracker and network, drawn from a seed."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass
class StreamFaults:
    """What is wrong with the stream at the moment; everything may be changed at any time from any thread."""

    seed: int = 0  # of everything that is drawn
    silent: bool = False  # whether nothing is sent; frames are counted on
    loss: float = 0.0  # probability that a packet is lost
    frozen: bool = False  # whether the object is occluded: its last pose is repeated
    zeroed: bool = False  # whether the object's pose is all zeros
    absent: bool = False  # whether the object is left out of the packets
    wrong_name: str | None = None  # under which the object is sent instead of its own
    not_finite: bool = False  # whether the pose holds a NaN
    jump: Sequence[float] = (0.0, 0.0, 0.0)  # by which the object is seen elsewhere, in Vicon's axes [m]
    outliers: float = 0.0  # probability that a single pose is seen `outlier_distance` away
    outlier_distance: float = 0.5  # [m]
    delay: float = 0.0  # how late packets are; they stay in order [s]
    jitter: float = 0.0  # how much later they are at most, drawn for each [s]
    reorder: float = 0.0  # probability that a packet comes after the next one
    duplicate: float = 0.0  # probability that a packet comes twice
    truncate: float = 0.0  # probability that a packet ends early
    corrupt: float = 0.0  # probability that bits of a packet flip
    garbage: float = 0.0  # probability that random bytes are sent before a packet
    stride: int = 1  # only every n-th frame is sent
    stuck_number: bool = False  # whether frames keep the number of the last one
    number_offset: int = 0  # added to the frame numbers
    _random: random.Random = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)

    def strike(self, probability: float) -> bool:
        return probability > 0.0 and self._random.random() < probability

    def lateness(self) -> float:
        return self.delay + self._random.uniform(0.0, self.jitter)

    def direction(self) -> tuple[float, float, float]:
        x, y, z = (self._random.gauss(0.0, 1.0) for _ in range(3))
        length = (x * x + y * y + z * z) ** 0.5
        return (x / length, y / length, z / length)

    def noise(self, deviation: float) -> tuple[float, float, float]:
        x, y, z = (self._random.gauss(0.0, deviation) for _ in range(3))
        return (x, y, z)

    def spoil(self, datagram: bytes) -> bytes:
        if self.strike(self.corrupt):
            spoilt = bytearray(datagram)
            for _ in range(self._random.randint(1, 8)):
                spoilt[self._random.randrange(len(spoilt))] ^= 1 << self._random.randrange(8)
            datagram = bytes(spoilt)
        return datagram[: self._random.randrange(len(datagram))] if self.strike(self.truncate) else datagram

    def random_bytes(self) -> bytes:
        return self._random.randbytes(self._random.randrange(1100))
