"""Bytes on the servos' side of the bus: instruction packets in, status packets out (DYNAMIXEL protocol 2.0).

Written from the protocol's description alone and sharing nothing with the adapter, so that neither forgives the other.
"""

from __future__ import annotations

from dataclasses import dataclass

HEADER = b"\xff\xff\xfd\x00"
BROADCAST = 0xFE
STATUS = 0x55
MAX_LENGTH = 1024

POLYNOMIAL = 0x8005
"""CRC-16: x¹⁶ + x¹⁵ + x² + 1, most significant bit first, initial value 0, nothing reflected."""


def _remainder(byte: int) -> int:
    register = byte << 8
    for _ in range(8):
        register = ((register << 1) ^ POLYNOMIAL if register & 0x8000 else register << 1) & 0xFFFF
    return register


_REMAINDERS = tuple(_remainder(byte) for byte in range(256))


def checksum(data: bytes) -> int:
    """CRC-16 over a packet without its last two bytes."""
    register = 0
    for byte in data:
        register = (register << 8 & 0xFFFF) ^ _REMAINDERS[register >> 8 ^ byte]
    return register


def status_packet(servo_id: int, error: int, parameters: bytes = b"") -> bytes:
    body = bytearray((STATUS, error))
    for byte in parameters:
        body.append(byte)
        if body[-3:] == b"\xff\xff\xfd":
            body.append(0xFD)
    packet = HEADER + bytes((servo_id,)) + (len(body) + 2).to_bytes(2, "little") + bytes(body)
    return packet + checksum(packet).to_bytes(2, "little")


@dataclass(frozen=True)
class Instruction:
    servo_id: int  # whom it is for; `BROADCAST` for all
    code: int  # what is to be done
    parameters: bytes  # unstuffed
    intact: bool  # whether its CRC is right


class InstructionStream:
    """Finds instruction packets in a stream of bytes; status packets of other servos are heard and passed over."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, data: bytes) -> list[Instruction]:
        self._bytes += data
        heard = []
        while (packet := self._next()) is not None:
            if packet[7] != STATUS:
                heard.append(self._decode(packet))
        return heard

    def idle(self) -> None:
        """Forget a packet that was begun and not finished: the line has been silent for longer than a byte may take."""
        self._bytes.clear()

    def _next(self) -> bytes | None:
        while True:
            start = self._bytes.find(HEADER)
            if start < 0:
                del self._bytes[:-3]
                return None
            del self._bytes[:start]
            if len(self._bytes) < 7:
                return None
            length = int.from_bytes(self._bytes[5:7], "little")
            if not 3 <= length <= MAX_LENGTH:
                del self._bytes[:4]
                continue
            if len(self._bytes) < 7 + length:
                return None
            packet = bytes(self._bytes[: 7 + length])
            del self._bytes[: 7 + length]
            return packet

    @staticmethod
    def _decode(packet: bytes) -> Instruction:
        parameters = bytearray()
        begun = False
        for byte in packet[8:-2]:
            if not (begun and byte == 0xFD):
                parameters.append(byte)
            begun = not (begun and byte == 0xFD) and parameters[-3:] == b"\xff\xff\xfd"
        intact = checksum(packet[:-2]) == int.from_bytes(packet[-2:], "little")
        return Instruction(packet[4], packet[7], bytes(parameters), intact)
