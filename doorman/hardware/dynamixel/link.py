"""Instructions to servos and their answers: one at a time, each with a deadline and a typed outcome; and reading all servos."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.packets import (
    BROADCAST_ID,
    OVERHEAD,
    StatusPacket,
    StatusParser,
    instruction_packet,
)
from doorman.hardware.dynamixel.port import Port
from doorman.hardware.dynamixel.registers import (
    BLOCK_SIZE,
    BUS_WATCHDOG,
    INDIRECT_DATA,
    RETURN_DELAY_UNIT,
    WATCHDOG_OFF,
    Instruction,
    Register,
)

BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""
LONGEST_RETURN_DELAY = 254 * RETURN_DELAY_UNIT
FLOOD = 64
"""Chunks after which a line is given up that does not fall silent."""


class Outcome(Enum):
    OK = "ok"
    TIMEOUT = "no answer"
    CORRUPT = "damaged answer"
    REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class Reply:
    outcome: Outcome
    sent: float  # just before the instruction was sent [s]: what the answer says is not older
    received: float  # just after the answer was read [s]
    error_number: int = 0  # why the servo refused
    alert: bool = False  # whether a hardware error stands in the servo
    data: bytes = b""

    @property
    def ok(self) -> bool:
        """Whether the instruction was carried out and its answer is whole."""
        return self.outcome is Outcome.OK


class Link:
    """Speaks protocol 2.0 over a port. Not for use by two threads at a time."""

    def __init__(
        self,
        port: Port,
        baud_rate: int,
        latency: float,
        return_delay: float = LONGEST_RETURN_DELAY,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._port = port
        self._byte_time = BITS_PER_BYTE / baud_rate
        self._latency = latency
        self._return_delay = return_delay
        self._clock = clock
        self._parser = StatusParser()
        self._owed = False

    def now(self) -> float:
        return self._clock()

    def ping(self, servo_id: int) -> Reply:
        return self._ask(servo_id, Instruction.PING, b"", 3)

    def read(self, servo_id: int, address: int, length: int) -> Reply:
        return self._ask(servo_id, Instruction.READ, _words(address, length), length)

    def write(self, servo_id: int, address: int, data: bytes) -> Reply:
        return self._ask(servo_id, Instruction.WRITE, _words(address) + data, 0)

    def reboot(self, servo_id: int) -> Reply:
        return self._ask(servo_id, Instruction.REBOOT, b"", 0)

    def sync_read(self, servo_ids: Sequence[int], address: int, length: int) -> list[Reply]:
        packet = instruction_packet(BROADCAST_ID, Instruction.SYNC_READ, _words(address, length) + bytes(servo_ids))
        return self._exchange(packet, servo_ids, length)

    def sync_write(self, register: Register, values: Mapping[int, int]) -> bool:
        """Write one register of several servos with one instruction, which no servo answers."""
        parameters = _words(register.address, register.size)
        for servo_id, value in values.items():
            parameters += bytes((servo_id,)) + register.encode(value)
        packet = instruction_packet(BROADCAST_ID, Instruction.SYNC_WRITE, parameters)
        return self._port.send(packet, self._clock() + self._allowance(len(packet), 0, 0))

    def clear_watchdog(self, servo_id: int, goal: Register) -> None:
        """Clear a servo's bus watchdog and zero its goal back to back; neither is answered, so look whether it was heard."""
        self.sync_write(BUS_WATCHDOG, {servo_id: WATCHDOG_OFF})
        self.sync_write(goal, {servo_id: 0})

    def _ask(self, servo_id: int, instruction: Instruction, parameters: bytes, length: int) -> Reply:
        return self._exchange(instruction_packet(servo_id, instruction, parameters), (servo_id,), length)[0]

    def _allowance(self, sent: int, servos: int, length: int) -> float:
        answers = servos * (OVERHEAD + length + length // 3)
        return self._byte_time * (sent + answers) + servos * self._return_delay + self._latency

    def _exchange(self, packet: bytes, servo_ids: Sequence[int], length: int) -> list[Reply]:
        """Send an instruction and collect the answers, which servos give in the order in which they were asked."""
        # An answer out of order belongs to an earlier instruction: whatever came before it is not believed.
        self._settle()
        self._parser.restart(length)
        sent = self._clock()
        allowance = self._allowance(len(packet), len(servo_ids), length)
        answers: dict[int, tuple[StatusPacket, float]] = {}
        if self._port.send(packet, sent + allowance):
            self._collect(self._clock() + allowance, servo_ids, answers)
        self._owed = len(answers) < len(servo_ids)
        return [self._reply(sent, answers.get(index), length) for index in range(len(servo_ids))]

    def _collect(
        self, deadline: float, servo_ids: Sequence[int], answers: dict[int, tuple[StatusPacket, float]]
    ) -> None:
        """Take answers until all are there, or until the deadline has passed and nothing more lies ready."""
        # What arrived in time counts even if this thread was held up and looks only later.
        late = 0
        while len(answers) < len(servo_ids):
            data = self._port.receive(deadline)
            now = self._clock()
            for status in self._parser.feed(data):
                self._sort_in(status, now, servo_ids, answers)
            late += now >= deadline
            if late > FLOOD or (late and not data):
                break
        else:
            return
        for status in self._parser.finish():
            self._sort_in(status, self._clock(), servo_ids, answers)

    @staticmethod
    def _sort_in(
        status: StatusPacket, now: float, servo_ids: Sequence[int], answers: dict[int, tuple[StatusPacket, float]]
    ) -> None:
        if status.servo_id not in servo_ids:
            return
        index = servo_ids.index(status.servo_id)
        for later in [known for known in answers if known >= index]:
            del answers[later]
        answers[index] = (status, now)

    def _reply(self, sent: float, answer: tuple[StatusPacket, float] | None, length: int) -> Reply:
        if answer is None:
            missing = Outcome.CORRUPT if self._parser.damaged else Outcome.TIMEOUT
            return Reply(missing, sent, self._clock())
        status, received = answer
        if status.error_number:
            outcome = Outcome.REFUSED
        else:
            outcome = Outcome.OK if len(status.parameters) == length else Outcome.CORRUPT
        data = status.parameters if outcome is Outcome.OK else b""
        return Reply(outcome, sent, received, status.error_number, status.alert, data)

    def _settle(self) -> None:
        """Throw away what is left of earlier instructions; if one was not answered, wait until its answer is unlikely."""
        quiet_until = self._clock() + (self._latency if self._owed else 0.0)
        for _ in range(FLOOD):
            data = self._port.receive(quiet_until)
            if not data and self._clock() >= quiet_until:
                return


def _words(*values: int) -> bytes:
    return b"".join(value.to_bytes(2, "little") for value in values)


PROBE_INTERVAL = 0.05
"""Time between two looks for a missing servo [s]."""


class ServoReader:
    # In a sync read every servo waits for its predecessor's answer, so one silent servo silences those after it: they are asked
    # one by one, and a servo that stays silent is left out and only looked for now and then.

    def __init__(self, link: Link, config: ServoConfig) -> None:
        self._link = link
        self._ids = config.ids
        self._next_probe = 0.0
        self.absent: set[int] = set()  # joints that are left out of the sync read and looked for
        self.excluded: int | None = None  # joint that is left alone altogether while it is being recovered

    def read(self) -> dict[int, Reply]:
        present = [joint for joint in range(len(self._ids)) if joint not in self.absent and joint != self.excluded]
        replies: dict[int, Reply] = {}
        if present:
            answers = self._link.sync_read([self._ids[joint] for joint in present], INDIRECT_DATA, BLOCK_SIZE)
            replies = dict(zip(present, answers, strict=True))
            silent = [joint for joint in present if replies[joint].outcome in (Outcome.TIMEOUT, Outcome.CORRUPT)]
            for joint in silent[1:]:
                replies[joint] = self._read_one(joint)
        return replies | self._probe()

    def _probe(self) -> dict[int, Reply]:
        wanted = sorted(self.absent - {self.excluded})
        if not wanted or self._link.now() < self._next_probe:
            return {}
        joint = wanted[int(self._next_probe / PROBE_INTERVAL) % len(wanted)]
        self._next_probe = self._link.now() + PROBE_INTERVAL
        return {joint: self._read_one(joint)}

    def _read_one(self, joint: int) -> Reply:
        return self._link.read(self._ids[joint], INDIRECT_DATA, BLOCK_SIZE)
