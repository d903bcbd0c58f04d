"""Faults of an emulated bus: switched while it runs, drawn from a seed."""

from __future__ import annotations

import random
from dataclasses import dataclass, field


@dataclass
class BusFaults:
    """What is wrong with the bus at the moment; everything may be changed at any time from any thread."""

    seed: int = 0  # of everything that is drawn
    silent: set[int] = field(default_factory=set)
    """Ids of servos that neither hear nor answer, as with a broken cable."""
    mute: set[int] = field(default_factory=set)  # ids of servos that hear and obey but do not answer
    drop: float = 0.0  # probability that a status packet is lost
    corrupt: float = 0.0  # probability that a bit of a status packet flips
    truncate: float = 0.0  # probability that a status packet ends early
    noise: float = 0.0  # probability that random bytes stand before a status packet
    deafness: float = 0.0  # probability that a bit of what the servos hear flips
    delay: float = 0.0  # how late status packets are [s]
    frozen: set[int] = field(default_factory=set)  # ids of servos that repeat their last status packet of every kind
    echo: bool = False  # whether the adapter hears its own bytes, as on a two-wire bus without switching
    babble: bool = False  # whether random bytes flood the bus
    chain_breaks: bool = True
    """Whether a servo whose predecessor in a sync or bulk read stays silent stays silent too."""

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)

    def strike(self, probability: float) -> bool:
        return probability > 0.0 and self._random.random() < probability

    def random_bytes(self, longest: int) -> bytes:
        return self._random.randbytes(self._random.randint(1, longest))

    def spoil(self, packet: bytes) -> bytes:
        """Let noise, truncation and bit flips act on a status packet."""
        if self.strike(self.corrupt):
            packet = self.flip(packet)
        if self.strike(self.truncate):
            packet = packet[: self._random.randrange(len(packet))]
        if self.strike(self.noise):
            packet = self.random_bytes(20) + packet
        return packet

    def flip(self, data: bytes) -> bytes:
        spoiled = bytearray(data)
        spoiled[self._random.randrange(len(spoiled))] ^= 1 << self._random.randrange(8)
        return bytes(spoiled)
