"""Records of an MCAP file outside chunks, if they are whole."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, McapRecord, MessageIndex, Metadata, Schema

from doorman.bounds import LARGEST_CHUNK

COMPRESSION = "zstd"
_READERS: dict[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.HEADER: Header.read, Opcode.SCHEMA: Schema.read, Opcode.CHANNEL: Channel.read, Opcode.CHUNK: Chunk.read,
    Opcode.MESSAGE_INDEX: MessageIndex.read, Opcode.ATTACHMENT: Attachment.read, Opcode.METADATA: Metadata.read,
    Opcode.DATA_END: DataEnd.read,
}  # fmt: skip
"""What doorman writes outside chunks, up to the summary."""


def whole_record(opcode: int, content: bytes) -> McapRecord | None:
    """What a record holds, a chunk decompressed; None if it is none that doorman writes, or is visibly damaged."""
    stream = ReadDataStream(BytesIO(content))
    try:
        record: McapRecord | None = _READERS[opcode](stream)
        if isinstance(record, Chunk):
            record = _decompressed(record)
    except Exception:  # parsers raise whatever they stumble over
        return None
    if isinstance(record, Attachment) and zlib.crc32(content[:-4]) != int.from_bytes(content[-4:], "little"):
        return None
    return record if stream.count == len(content) else None


def _decompressed(chunk: Chunk) -> Chunk | None:
    """A chunk as it was; None if that is not what it says, or too much: a frame of some kilobytes may say terabytes."""
    size = chunk.uncompressed_size
    if chunk.compression != COMPRESSION or size > LARGEST_CHUNK:
        return None
    content = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(size + 1)
    whole = len(content) == size and zlib.crc32(content) == chunk.uncompressed_crc
    return replace(chunk, compression="", data=content) if whole else None
