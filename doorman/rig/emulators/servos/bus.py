"""Who answers what, and when, on a bus of emulated servos."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np

from doorman.rig.emulators.servos.faults import BusFaults
from doorman.rig.emulators.servos.memory import PacketError
from doorman.rig.emulators.servos.packets import (
    BROADCAST,
    MAX_LENGTH,
    Instruction,
    fast_status_packet,
    status_packet,
)
from doorman.rig.emulators.servos.plant import ServoPlant
from doorman.rig.emulators.servos.unit import EmulatedServo

PING, READ = 0x01, 0x02
SYNC_READ, SYNC_WRITE, BULK_READ, BULK_WRITE = 0x82, 0x83, 0x92, 0x93
FAST_SYNC_READ, FAST_BULK_READ = 0x8A, 0x9A
QUESTIONS = frozenset({PING, READ, SYNC_READ, BULK_READ, FAST_SYNC_READ, FAST_BULK_READ})
"""Instructions that change nothing."""
FAST_FIRMWARE = 45
"""Oldest firmware that knows the fast reads."""
BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""
RETURN_DELAY_UNIT = 2e-6
"""One count of the return delay time [s]."""


@dataclass(frozen=True)
class _Answer:
    servo: EmulatedServo  # who begins it
    packet: bytes


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
        for answer in self._answers(now, instruction, listening):
            start += answer.servo.memory.get("return delay time") * RETURN_DELAY_UNIT
            start += self._byte_time * len(answer.packet) + self._faults.delay
            if not self._faults.strike(self._faults.drop):
                replies.append((start, self._faults.spoil(answer.packet)))
        self._line_free = start if self._byte_time else now
        return replies

    def _answer(self, code: int, servo: EmulatedServo, error: int, data: bytes) -> _Answer:
        return _Answer(servo, self._thaw(code, servo.servo_id, status_packet(servo.servo_id, error, data)))

    def _thaw(self, code: int, servo_id: int, packet: bytes) -> bytes:
        """A packet, or what a frozen servo says instead."""
        if servo_id in self._faults.frozen:
            packet = self._last_packets.get((servo_id, code), packet)
        self._last_packets[servo_id, code] = packet
        return packet

    def _speaks(self, servo: EmulatedServo | None) -> TypeGuard[EmulatedServo]:
        return (
            servo is not None
            and servo.memory.get("status return level") >= 1
            and servo.servo_id not in self._faults.mute
        )

    def _answers(self, now: float, instruction: Instruction, listening: list[EmulatedServo]) -> Iterator[_Answer]:
        by_id = {servo.servo_id: servo for servo in listening}
        if instruction.code in (SYNC_WRITE, BULK_WRITE):
            if instruction.intact and instruction.servo_id == BROADCAST:
                self._write_many(instruction, by_id)
        elif instruction.code in (SYNC_READ, BULK_READ):
            if instruction.intact and instruction.servo_id == BROADCAST:
                yield from self._read_many(instruction, by_id)
        elif instruction.code in (FAST_SYNC_READ, FAST_BULK_READ):
            if instruction.intact and instruction.servo_id == BROADCAST:
                yield from self._read_fast(instruction, by_id)
        elif instruction.servo_id == BROADCAST:
            for servo in sorted(listening, key=lambda servo: servo.servo_id):
                yield from self._execute(now, instruction, servo)
        else:
            for servo in listening:
                if servo.servo_id == instruction.servo_id:
                    yield from self._execute(now, instruction, servo)
                elif servo.is_grouped(instruction):
                    servo.execute(now, instruction)  # nobody answers to a secondary id

    def _execute(self, now: float, instruction: Instruction, servo: EmulatedServo) -> Iterator[_Answer]:
        status = servo.execute(now, instruction)
        if status is not None and servo.servo_id not in self._faults.mute:
            yield self._answer(instruction.code, servo, *status)

    def _read_many(self, instruction: Instruction, by_id: dict[int, EmulatedServo]) -> Iterator[_Answer]:
        for servo_id, address, length in _wanted(instruction):
            servo = by_id.get(servo_id)
            if not self._speaks(servo):
                if self._faults.chain_breaks:
                    return
                continue
            error, data = servo.memory.read(address, length)
            yield self._answer(instruction.code, servo, servo.error_byte(error), data)

    def _read_fast(self, instruction: Instruction, by_id: dict[int, EmulatedServo]) -> Iterator[_Answer]:
        """One packet of all servos: it breaks off at the first that stays silent, since the others wait for it."""
        wanted = list(_wanted(instruction))
        announced = 1 + sum(length + 4 for _, _, length in wanted)
        parts = []
        for servo_id, address, length in wanted:
            servo = by_id.get(servo_id)
            if not self._speaks(servo) or servo.memory.get("firmware version") < FAST_FIRMWARE:
                break
            error, data = servo.memory.read(address, length)
            if error is not PacketError.NONE:
                break  # what a servo says then is not documented
            parts.append(self._thaw(instruction.code, servo_id, bytes((servo.error_byte(error), servo_id)) + data))
        if parts and announced <= MAX_LENGTH:
            yield _Answer(by_id[wanted[0][0]], fast_status_packet(announced, parts))

    @staticmethod
    def _write_many(instruction: Instruction, by_id: dict[int, EmulatedServo]) -> None:
        for servo_id, address, data in _given(instruction):
            if servo_id in by_id:
                by_id[servo_id].write(address, data)


def _wanted(instruction: Instruction) -> Iterator[tuple[int, int, int]]:
    """Id, address and length of everything that a sync or bulk read asks for."""
    parameters = instruction.parameters
    if instruction.code in (SYNC_READ, FAST_SYNC_READ):
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
