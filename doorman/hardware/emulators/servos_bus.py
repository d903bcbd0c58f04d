"""Who answers what, and when, on a bus of emulated servos."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from doorman.hardware.emulators.servos_faults import BusFaults
from doorman.hardware.emulators.servos_packets import BROADCAST, Instruction, status_packet
from doorman.hardware.emulators.servos_plant import ServoPlant
from doorman.hardware.emulators.servos_unit import EmulatedServo

PING, READ = 0x01, 0x02
SYNC_READ, SYNC_WRITE, BULK_READ, BULK_WRITE = 0x82, 0x83, 0x92, 0x93
QUESTIONS = frozenset({PING, READ, SYNC_READ, BULK_READ})
"""Instructions that change nothing."""
BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""
RETURN_DELAY_UNIT = 2e-6
"""One count of the return delay time [s]."""


@dataclass(frozen=True)
class _Answer:
    servo: EmulatedServo
    error: int
    data: bytes


class ServoBusLogic:
    """All servos of one bus and the plant that they share.

    Args:
        servos: In the order of the plant's joints.
        plant: What they move.
        faults: What is wrong with the bus.
        baud_rate: Of the wire [bit/s]; None for one that takes no time.
    """

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
        """Pass goals to the plant and its motion to the registers.

        Args:
            now: Of a monotonic clock [s].
        """
        rates = np.array([servo.goal_rate(now) for servo in self._servos])
        powered = np.array([servo.is_driven(now) for servo in self._servos])
        self._plant.drive(now, rates, powered)
        motion = self._plant.motion(now)
        for index, servo in enumerate(self._servos):
            if servo.is_up(now):
                servo.sense(now, motion.angles[index], motion.rates[index], motion.currents[index])

    def respond(self, now: float, instruction: Instruction, rate: int | None = None) -> list[tuple[float, bytes]]:
        """Let the servos act on an instruction.

        Args:
            now: When it was heard [s].
            instruction: What was heard.
            rate: Of the port that it came from [bit/s]; to servos of another one it is noise. None: everyone hears it.

        Returns:
            Status packets as they arrive at the adapter, with the times when they do.
        """
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
        for answer in self._answers(now, instruction, listening):
            packet = self._packet(instruction, answer)
            start += answer.servo.memory.get("return delay time") * RETURN_DELAY_UNIT + self._byte_time * len(packet)
            start += self._faults.delay
            if not self._faults.strike(self._faults.drop):
                replies.append((start, self._faults.spoil(packet)))
        self._line_free = start if self._byte_time else now
        return replies

    def _packet(self, instruction: Instruction, answer: _Answer) -> bytes:
        key = (answer.servo.servo_id, instruction.code)
        packet = status_packet(key[0], answer.error, answer.data)
        if key[0] in self._faults.frozen:
            packet = self._last_packets.get(key, packet)
        self._last_packets[key] = packet
        return packet

    def _answers(self, now: float, instruction: Instruction, listening: list[EmulatedServo]) -> Iterator[_Answer]:
        by_id = {servo.servo_id: servo for servo in listening}
        if instruction.code in (SYNC_WRITE, BULK_WRITE):
            if instruction.intact and instruction.servo_id == BROADCAST:
                self._write_many(instruction, by_id)
        elif instruction.code in (SYNC_READ, BULK_READ):
            if instruction.intact and instruction.servo_id == BROADCAST:
                yield from self._read_many(instruction, by_id)
        elif instruction.servo_id == BROADCAST:
            for servo in sorted(listening, key=lambda servo: servo.servo_id):
                yield from self._execute(now, instruction, servo)
        elif instruction.servo_id in by_id:
            yield from self._execute(now, instruction, by_id[instruction.servo_id])

    def _execute(self, now: float, instruction: Instruction, servo: EmulatedServo) -> Iterator[_Answer]:
        status = servo.execute(now, instruction)
        if status is not None and servo.servo_id not in self._faults.mute:
            yield _Answer(servo, *status)

    def _read_many(self, instruction: Instruction, by_id: dict[int, EmulatedServo]) -> Iterator[_Answer]:
        for servo_id, address, length in _wanted(instruction):
            servo = by_id.get(servo_id)
            speaks = servo is not None and servo.memory.get("status return level") >= 1
            if servo is None or not speaks or servo_id in self._faults.mute:
                if self._faults.chain_breaks:
                    return
                continue
            error, data = servo.memory.read(address, length)
            yield _Answer(servo, servo.error_byte(error), data)

    @staticmethod
    def _write_many(instruction: Instruction, by_id: dict[int, EmulatedServo]) -> None:
        for servo_id, address, data in _given(instruction):
            if servo_id in by_id:
                by_id[servo_id].write(address, data)


def _wanted(instruction: Instruction) -> Iterator[tuple[int, int, int]]:
    """Id, address and length of everything that a sync or bulk read asks for."""
    parameters = instruction.parameters
    if instruction.code == SYNC_READ:
        address, length = int.from_bytes(parameters[0:2], "little"), int.from_bytes(parameters[2:4], "little")
        for servo_id in parameters[4:]:
            yield servo_id, address, length
        return
    for start in range(0, len(parameters) - 4, 5):
        row = parameters[start : start + 5]
        yield row[0], int.from_bytes(row[1:3], "little"), int.from_bytes(row[3:5], "little")


def _given(instruction: Instruction) -> Iterator[tuple[int, int, bytes]]:
    """Id, address and bytes of everything that a sync or bulk write sets."""
    parameters = instruction.parameters
    if instruction.code == SYNC_WRITE:
        address, length = int.from_bytes(parameters[0:2], "little"), int.from_bytes(parameters[2:4], "little")
        for start in range(4, len(parameters) - length, length + 1):
            yield parameters[start], address, parameters[start + 1 : start + 1 + length]
        return
    start = 0
    while start + 5 <= len(parameters):
        length = int.from_bytes(parameters[start + 3 : start + 5], "little")
        data = parameters[start + 5 : start + 5 + length]
        if len(data) == length:
            yield parameters[start], int.from_bytes(parameters[start + 1 : start + 3], "little"), data
        start += 5 + length
