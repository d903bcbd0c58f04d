"""Who answers what, and when, on a bus of emulated servos, what is wrong with it, and the joints that they move."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.arrays import Array
from doorman.checks import vector
from doorman.rig.emulators.servos.packets import BROADCAST, Instruction, status_packet
from doorman.rig.emulators.servos.unit import EmulatedServo


@dataclass(frozen=True)
class ServoMotion:
    angles: Array  # shape (n,) [rad]
    rates: Array  # shape (n,) [rad/s]
    currents: Array  # positive where they push the angle up, shape (n,) [A]


class ServoPlant(Protocol):
    """Mechanics behind emulated servos; called from the emulator's thread."""

    def drive(self, time: float, rates: Array, powered: NDArray[np.bool_]) -> None:
        """Take goal rates; they hold until the next call."""

    def motion(self, time: float) -> ServoMotion:
        """Motion at a time not before that of the last call."""


class LaggingJoints:
    """Joints that follow their goal rate with a first-order lag, whatever loads them."""

    inertia = 0.005  # current that they draw to speed up [A s²/rad]

    def __init__(
        self, angles: ArrayLike, time_constant: float = 0.02, stops: tuple[float, float] = (-math.inf, math.inf)
    ) -> None:
        self._angles = vector(angles, np.size(angles), "angles")
        self._rates = np.zeros_like(self._angles)
        self._goals = np.zeros_like(self._angles)
        self._time_constant = time_constant
        self._stops = stops
        self._time: float | None = None

    def drive(self, time: float, rates: Array, powered: NDArray[np.bool_]) -> None:
        self._advance(time)
        self._goals = np.where(powered, rates, 0.0)

    def motion(self, time: float) -> ServoMotion:
        self._advance(time)
        accelerations = (self._goals - self._rates) / self._time_constant
        return ServoMotion(self._angles.copy(), self._rates.copy(), self.inertia * accelerations)

    def _advance(self, time: float) -> None:
        """Solve the lag exactly up to a time."""
        step = 0.0 if self._time is None else max(time - self._time, 0.0)
        self._time = time
        decay = math.exp(-step / self._time_constant)
        difference = self._rates - self._goals
        self._angles = self._angles + self._goals * step + difference * self._time_constant * (1.0 - decay)
        self._rates = self._goals + difference * decay
        stopped = np.clip(self._angles, *self._stops)
        self._rates = np.where(stopped == self._angles, self._rates, 0.0)
        self._angles = stopped


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

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)

    def strike(self, probability: float) -> bool:
        return probability > 0.0 and self._random.random() < probability

    def random_bytes(self, longest: int) -> bytes:
        return self._random.randbytes(self._random.randint(1, longest))

    def spoil(self, packet: bytes) -> bytes:
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


PING, READ, SYNC_READ, SYNC_WRITE = 0x01, 0x02, 0x82, 0x83
QUESTIONS = frozenset({PING, READ, SYNC_READ})
"""Instructions that change nothing."""
BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""


class ServoBusLogic:
    def __init__(
        self, servos: Sequence[EmulatedServo], plant: ServoPlant, faults: BusFaults, baud_rate: int | None
    ) -> None:
        self._servos = servos
        self._plant = plant
        self._faults = faults
        self._byte_time = 0.0 if baud_rate is None else BITS_PER_BYTE / baud_rate
        self._line_free = 0.0
        self._last_packets: dict[tuple[int, int], bytes] = {}

    def tick(self, now: float) -> None:
        """Pass goals to the plant and its motion to the registers."""
        rates = np.array([servo.goal_rate(now) for servo in self._servos])
        powered = np.array([servo.is_driven(now) for servo in self._servos])
        self._plant.drive(now, rates, powered)
        motion = self._plant.motion(now)
        for index, servo in enumerate(self._servos):
            if servo.is_up(now):
                servo.sense(now, motion.angles[index], motion.rates[index], motion.currents[index])

    def respond(self, now: float, instruction: Instruction, rate: int | None = None) -> list[tuple[float, bytes]]:
        self.tick(now)
        listening = [
            servo
            for servo in self._servos
            if servo.is_up(now) and servo.servo_id not in self._faults.silent and rate in (None, servo.baud_rate)
        ]
        if instruction.intact:
            for servo in listening:
                servo.hear(now)
        start = max(now, self._line_free) + self._byte_time * (len(instruction.parameters) + 10)
        replies = []
        for servo, error, data in self._answers(now, instruction, listening):
            packet = self._said(instruction.code, servo.servo_id, status_packet(servo.servo_id, error, data))
            start += servo.memory.measure("return delay time")
            start += self._byte_time * len(packet) + self._faults.delay
            if not self._faults.strike(self._faults.drop):
                replies.append((start, self._faults.spoil(packet)))
        self._line_free = start if self._byte_time else now
        return replies

    def _said(self, code: int, servo_id: int, packet: bytes) -> bytes:
        """A status packet, or what a frozen servo says instead."""
        if servo_id not in self._faults.frozen:
            self._last_packets[servo_id, code] = packet
        return self._last_packets.setdefault((servo_id, code), packet)

    def _answers(
        self, now: float, instruction: Instruction, listening: list[EmulatedServo]
    ) -> Iterator[tuple[EmulatedServo, int, bytes]]:
        """Who answers, with error byte and data; servos that are mute obey in silence."""
        if instruction.code in (SYNC_READ, SYNC_WRITE):
            if instruction.intact and instruction.servo_id == BROADCAST:
                yield from self._for_many(instruction, {servo.servo_id: servo for servo in listening})
            return
        for servo in sorted(listening, key=lambda servo: servo.servo_id):
            if instruction.servo_id in (BROADCAST, servo.servo_id):
                status = servo.execute(now, instruction)
                if status is not None and servo.servo_id not in self._faults.mute:
                    yield servo, *status

    def _for_many(
        self, instruction: Instruction, by_id: dict[int, EmulatedServo]
    ) -> Iterator[tuple[EmulatedServo, int, bytes]]:
        address, length = (int.from_bytes(instruction.parameters[at : at + 2], "little") for at in (0, 2))
        rest = instruction.parameters[4:]
        if instruction.code == SYNC_WRITE:
            for start in range(0, len(rest) - length, length + 1):
                if rest[start] in by_id:
                    by_id[rest[start]].write(address, rest[start + 1 : start + 1 + length])
            return
        for servo_id in rest:
            servo = by_id.get(servo_id)
            if servo is None or servo.memory.get("status return level") < 1 or servo_id in self._faults.mute:
                return  # those after it stay silent, too
            error, data = servo.memory.read(address, length)
            yield servo, servo.error_byte(error), data
