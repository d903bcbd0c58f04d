"""Instructions to servos and their answers: one at a time, each with a deadline and a typed outcome; and reading all servos."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoFault
from doorman.hardware.dynamixel.packets import BROADCAST_ID, OVERHEAD, StatusPacket, StatusParser, instruction_packet
from doorman.hardware.dynamixel.port import SerialPort
from doorman.hardware.dynamixel.registers import BUS_WATCHDOG, TELEMETRY, WATCHDOG_OFF, Instruction, Register, Unit

BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""
LONGEST_RETURN_DELAY = 254 * Unit.RETURN_DELAY
FLOOD = 64
"""Chunks after which a line is given up that does not fall silent."""
UNANSWERED = ServoFault.TIMEOUT | ServoFault.CORRUPT


@dataclass(frozen=True, slots=True)
class Reply:
    fault: ServoFault  # `TIMEOUT`, `CORRUPT` or `REFUSED`; `NONE` if the instruction was carried out and its answer is whole
    sent: float  # just before the instruction was sent [s]: what the answer says is not older
    received: float  # just after the answer was read [s]
    error_number: int = 0  # why the servo refused
    alert: bool = False  # whether a hardware error stands in the servo
    data: bytes = b""

    @property
    def ok(self) -> bool:
        return self.fault is ServoFault.NONE


class Link:
    """Speaks protocol 2.0 over a port. Not for use by two threads at a time."""

    def __init__(
        self,
        port: SerialPort,
        baud_rate: int,
        latency: float,
        return_delay: float = LONGEST_RETURN_DELAY,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._port, self.now = port, clock
        self._byte_time, self._latency, self._return_delay = BITS_PER_BYTE / baud_rate, latency, return_delay
        self._parser = StatusParser()
        self._owed = False

    def ping(self, servo_id: int) -> Reply:
        return self._ask(servo_id, Instruction.PING, b"", 3)

    def read(self, servo_id: int, register: Register) -> Reply:
        return self._ask(servo_id, Instruction.READ, _place(register), register.size)

    def write(self, servo_id: int, register: Register, value: int) -> Reply:
        parameters = register.address.to_bytes(2, "little") + register.encode(value)
        return self._ask(servo_id, Instruction.WRITE, parameters, 0)

    def reboot(self, servo_id: int) -> Reply:
        return self._ask(servo_id, Instruction.REBOOT, b"", 0)

    def sync_read(self, servo_ids: Sequence[int], register: Register) -> list[Reply]:
        packet = instruction_packet(BROADCAST_ID, Instruction.SYNC_READ, _place(register) + bytes(servo_ids))
        return self._exchange(packet, servo_ids, register.size)

    def sync_write(self, register: Register, values: Mapping[int, int]) -> bool:
        """Write one register of several servos with one instruction, which no servo answers."""
        rows = (bytes((servo_id,)) + register.encode(value) for servo_id, value in values.items())
        packet = instruction_packet(BROADCAST_ID, Instruction.SYNC_WRITE, _place(register) + b"".join(rows))
        return self._port.send(packet, self.now() + self._allowance(len(packet), 0, 0))

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
        sent = self.now()
        allowance = self._allowance(len(packet), len(servo_ids), length)
        answers: dict[int, tuple[StatusPacket | None, float]] = {}
        if self._port.send(packet, sent + allowance):
            for statuses, received in self._heard(self.now() + allowance):
                for status in statuses:
                    if status.servo_id in servo_ids:
                        index = servo_ids.index(status.servo_id)
                        answers = {known: answer for known, answer in answers.items() if known < index}
                        answers[index] = status, received
                if len(answers) == len(servo_ids):
                    break
        self._owed = len(answers) < len(servo_ids)
        return [self._reply(sent, *answers.get(index, (None, self.now())), length) for index in range(len(servo_ids))]

    def _heard(self, deadline: float) -> Iterator[tuple[list[StatusPacket], float]]:
        """Answers and when they were read, until the deadline has passed and nothing more lies ready."""
        # What arrived in time counts even if this thread was held up and looks only later.
        late = 0
        while late <= FLOOD:
            data = self._port.receive(deadline)
            now = self.now()
            yield self._parser.feed(data), now
            late += now >= deadline
            if late and not data:
                break
        yield self._parser.finish(), self.now()

    def _reply(self, sent: float, status: StatusPacket | None, received: float, length: int) -> Reply:
        if status is None:
            return Reply(ServoFault.CORRUPT if self._parser.damaged else ServoFault.TIMEOUT, sent, received)
        if status.error_number:
            return Reply(ServoFault.REFUSED, sent, received, status.error_number, status.alert)
        if len(status.parameters) != length:
            return Reply(ServoFault.CORRUPT, sent, received, alert=status.alert)
        return Reply(ServoFault.NONE, sent, received, alert=status.alert, data=status.parameters)

    def _settle(self) -> None:
        """Throw away what is left of earlier instructions; if one was not answered, wait until its answer is unlikely."""
        quiet_until = self.now() + (self._latency if self._owed else 0.0)
        for _ in range(FLOOD):
            if not self._port.receive(quiet_until) and self.now() >= quiet_until:
                return


def _place(register: Register) -> bytes:
    return register.address.to_bytes(2, "little") + register.size.to_bytes(2, "little")


class ServoReader:
    # In a sync read every servo waits for its predecessor's answer, so one silent servo silences those after it: they are asked
    # one by one, and a servo that stays silent is left out and only looked for now and then.

    def __init__(self, link: Link, config: ServoConfig) -> None:
        self._link, self._ids = link, config.ids
        self._between = config.stale_after  # between two looks for a missing servo [s]
        self._next_probe = 0.0
        self.absent: set[int] = set()  # joints that are left out of the sync read and looked for
        self.excluded: int | None = None  # joint that is left alone altogether while it is being recovered

    def read(self) -> dict[int, Reply]:
        present = [joint for joint in range(len(self._ids)) if joint not in self.absent and joint != self.excluded]
        alone: list[int] = []
        replies: dict[int, Reply] = {}
        if present:
            answers = self._link.sync_read([self._ids[joint] for joint in present], TELEMETRY)
            replies = dict(zip(present, answers, strict=True))
            alone = [joint for joint in present if replies[joint].fault & UNANSWERED][1:]
        absent = sorted(self.absent - {self.excluded})
        if absent and self._link.now() >= self._next_probe:
            alone.append(absent[int(self._next_probe / self._between) % len(absent)])
            self._next_probe = self._link.now() + self._between
        return replies | {joint: self._link.read(self._ids[joint], TELEMETRY) for joint in alone}
