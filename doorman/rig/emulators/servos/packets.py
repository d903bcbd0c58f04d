"""Bytes on the servos' side of the bus: instruction packets in, status packets out (DYNAMIXEL protocol 2.0).

Written from the protocol's description and ROBOTIS's SDK, sharing nothing with the adapter, so that neither forgives the other.
"""

from __future__ import annotations

from dataclasses import dataclass

from dynamixel_sdk.protocol2_packet_handler import Protocol2PacketHandler

HEADER = b"\xff\xff\xfd\x00"
BROADCAST = 0xFE
STATUS = 0x55
MAX_LENGTH = 1024
_PATTERN, _STUFFED = b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"
"""Bytes of a header, and what a body has in their place."""
_SDK = Protocol2PacketHandler()


def checksum(data: bytes) -> int:
    """CRC-16 over a packet without its last two bytes."""
    return int(_SDK.updateCRC(0, data, len(data)))


def status_packet(servo_id: int, error: int, parameters: bytes = b"") -> bytes:
    body = (bytes((STATUS, error)) + parameters).replace(_PATTERN, _STUFFED)
    packet = HEADER + bytes((servo_id,)) + (len(body) + 2).to_bytes(2, "little") + body
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
                intact = checksum(packet[:-2]) == int.from_bytes(packet[-2:], "little")
                heard.append(Instruction(packet[4], packet[7], packet[8:-2].replace(_STUFFED, _PATTERN), intact))
        return heard

    def idle(self) -> None:
        """Forget a packet that was begun and not finished: the line has been silent for longer than a byte may take."""
        self._bytes.clear()

    def _next(self) -> bytes | None:
        while (start := self._bytes.find(HEADER)) >= 0:
            del self._bytes[:start]
            length = int.from_bytes(self._bytes[5:7], "little")
            if len(self._bytes) >= 7 and not 3 <= length <= MAX_LENGTH:
                del self._bytes[:4]
                continue
            if len(self._bytes) < 7 + length:
                return None
            packet = bytes(self._bytes[: 7 + length])
            del self._bytes[: 7 + length]
            return packet
        del self._bytes[:-3]
        return None
