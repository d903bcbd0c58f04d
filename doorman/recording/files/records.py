"""Records of an MCAP file: where each ends, and what it holds if it is whole."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import Any, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Chunk, Metadata

from doorman.bounds import LARGEST_CHUNK
from doorman.recording.files.mcap_file import COMPRESSION

PREFIX = struct.Struct("<BQ")
"""Opcode and length of a record."""
_IN_CHUNKS = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
_IGNORED = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.HEADER)
"""Records outside chunks that hold nothing that is needed from there."""


class Record(NamedTuple):
    opcode: int
    content: bytes
    end: int  # where the next one begins [bytes]

    def parsed(self) -> Any:
        """What it holds; None if it is none that doorman writes outside chunks, or is visibly damaged."""
        try:
            return _parsed(self.opcode, self.content)
        except Exception:  # parsers raise whatever they stumble over
            return None


def _parsed(opcode: int, content: bytes) -> Any:
    """What a record outside chunks holds; None or any exception if it makes no sense."""
    if opcode == Opcode.CHUNK:
        return _decompressed(Chunk.read(stream_of(content)))
    if opcode == Opcode.ATTACHMENT:
        whole = zlib.crc32(content[:-4]) == int.from_bytes(content[-4:], "little")
        return Attachment.read(stream_of(content)) if whole else None
    if opcode == Opcode.METADATA:
        stream = stream_of(content)
        metadata = Metadata.read(stream)
        return metadata if stream.count == len(content) else None
    if opcode == Opcode.MESSAGE_INDEX:
        return int.from_bytes(content[2:6], "little") == len(content) - 6 or None
    if opcode == Opcode.DATA_END:
        return len(content) == 4 or None
    return opcode in _IGNORED or None


def _decompressed(chunk: Chunk) -> bytes | None:
    """What a chunk holds; None if that is not what it says, or too much: a frame of some kilobytes may say terabytes."""
    size = chunk.uncompressed_size
    if chunk.compression != COMPRESSION or size > LARGEST_CHUNK:
        return None
    content = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(size + 1)
    return content if len(content) == size and zlib.crc32(content) == chunk.uncompressed_crc else None


def records_of(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Records of a chunk."""
    place = 0
    while place < len(content):
        if place + PREFIX.size > len(content):
            raise ValueError("a record is cut off")
        opcode, length = PREFIX.unpack_from(content, place)
        start = place + PREFIX.size
        place = start + length
        if opcode not in _IN_CHUNKS:
            raise ValueError("no record of a chunk")
        if place > len(content):
            raise ValueError("a record is cut off")
        yield opcode, start, place


def stream_of(content: bytes) -> Any:
    """Bytes as the parsers of `mcap` read them."""
    return ReadDataStream(BytesIO(content))
