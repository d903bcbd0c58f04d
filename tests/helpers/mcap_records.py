"""Records of an MCAP file, for tests that damage it."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator

SCHEMA, MESSAGE, CHUNK, MESSAGE_INDEX, ATTACHMENT, FOOTER = 3, 5, 6, 7, 9, 2


def records(data: bytes, begin: int = 8, end: int = 8) -> Iterator[tuple[int, int, bytes]]:
    """Place, opcode and body of every record outside chunks; without magic, of a chunk's content."""
    place = begin
    while place < len(data) - end:
        opcode, length = struct.unpack_from("<BQ", data, place)
        yield place, opcode, data[place + 9 : place + 9 + length]
        place += 9 + length


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def edited(content: bytes, edit: Callable[[int, bytes], bytes]) -> bytes:
    """A chunk's content whose records have other bodies."""
    return b"".join(record(opcode, edit(opcode, body)) for _, opcode, body in records(content, 0, 0))
