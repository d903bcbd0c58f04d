"""Packets of DYNAMIXEL protocol 2.0 as the adapter sends and receives them.

Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0" and "CRC Calculation".
"""

from __future__ import annotations

from dataclasses import dataclass

from doorman.hardware.dynamixel.registers import Instruction

HEADER = b"\xff\xff\xfd\x00"
BROADCAST_ID = 0xFE
HIGHEST_ID = 252
ALERT = 0x80
"""Bit of the error byte: a hardware error stands in the servo."""
OVERHEAD = 11
"""Bytes of a status packet without parameters."""
_PATTERN = b"\xff\xff\xfd"
_STUFFED = b"\xff\xff\xfd\xfd"
_SHORTEST = 4
_LONGEST_ECHO = 64
"""Longest instruction that may come back as an echo, counted like a packet's length."""


def _crc_table() -> tuple[int, ...]:
    table = []
    for value in range(0, 0x10000, 0x100):
        for _ in range(8):
            value = (value << 1) ^ (0x18005 if value & 0x8000 else 0)
        table.append(value)
    return tuple(table)


_TABLE = _crc_table()


def crc16(data: bytes | bytearray) -> int:
    crc = 0
    for byte in data:
        crc = (crc << 8 ^ _TABLE[crc >> 8 ^ byte]) & 0xFFFF
    return crc


def instruction_packet(servo_id: int, instruction: Instruction, parameters: bytes = b"") -> bytes:
    body = (bytes((instruction,)) + parameters).replace(_PATTERN, _STUFFED)
    packet = HEADER + bytes((servo_id,)) + (len(body) + 2).to_bytes(2, "little") + body
    return packet + crc16(packet).to_bytes(2, "little")


@dataclass(frozen=True, slots=True)
class StatusPacket:
    servo_id: int
    error: int  # error byte: alert bit and error number
    parameters: bytes  # unstuffed

    @property
    def alert(self) -> bool:
        return bool(self.error & ALERT)

    @property
    def error_number(self) -> int:
        return self.error & ~ALERT


class StatusParser:
    """Finds status packets in whatever arrives; never raises, never waits, takes linear time."""

    # A candidate is believed only if length, CRC and instruction are right. From any other one, only the header is thrown
    # away, so that a broken length cannot swallow the packets that follow it. Instruction packets, which two-wire adapters
    # echo, are passed over.

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._longest = _SHORTEST
        self.damaged = 0  # candidates that were not believed since `restart`

    def restart(self, longest: int) -> None:
        """Forget everything and expect the answers to a new instruction."""
        self._bytes.clear()
        self._longest = _SHORTEST + longest + (longest + 1) // 3
        self.damaged = 0

    def feed(self, data: bytes) -> list[StatusPacket]:
        self._bytes += data
        return self._parse(final=False)

    def finish(self) -> list[StatusPacket]:
        """Stop waiting for the rest of what was begun, and look for whole packets in it."""
        packets = self._parse(final=True)
        if self._bytes:
            self.damaged += 1
            self._bytes.clear()
        return packets

    def _parse(self, final: bool) -> list[StatusPacket]:
        found: list[StatusPacket] = []
        data, done = self._bytes, 0
        while (start := data.find(HEADER, done)) >= 0:
            length = data[start + 5] | data[start + 6] << 8 if len(data) >= start + 7 else _SHORTEST
            end = start + 7 + length
            if not 3 <= length <= max(self._longest, _LONGEST_ECHO) or (final and end > len(data)):
                self.damaged += 1
                done = start + len(HEADER)
            elif end > len(data):
                done = start
                break
            else:
                done = self._judge(start, end, found)
        if start < 0:
            done = max(done, len(data) - len(HEADER) + 1)
        del data[:done]
        return found

    def _judge(self, start: int, end: int, found: list[StatusPacket]) -> int:
        """Believe a whole candidate or not; where to look on."""
        packet = self._bytes[start:end]
        if crc16(packet[:-2]) != packet[-2] | packet[-1] << 8:
            self.damaged += 1
            return start + len(HEADER)
        if packet[7] == Instruction.STATUS and end - start - 7 <= self._longest and end - start >= OVERHEAD:
            body = bytes(packet[8:-2]).replace(_STUFFED, _PATTERN)
            if packet[4] <= HIGHEST_ID:
                found.append(StatusPacket(packet[4], body[0], body[1:]))
        return end
