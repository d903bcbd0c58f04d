"""An MCAP file as it is written: whole chunks, indexed, of messages that are framed already.

The library's own writer takes messages one by one, at twenty microseconds each. Records other than messages are the library's.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Mapping, Sequence
from typing import IO

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC as MAGIC

from doorman.recording.files.rows import Framed

COMPRESSION = "zstd"
_LEVEL = 1
"""Level of zstd: noise gets no smaller with more effort."""

_INDEX = struct.Struct("<BQHI")
"""Opcode, length, channel and size of a message index before its entries."""
_FOOTER = struct.Struct("<BQQQ")
"""What the checksum of the summary covers of the footer."""


class McapFile:
    def __init__(self, stream: IO[bytes], profile: str) -> None:
        self._stream, self._place = stream, 0
        self._compress = zstandard.ZstdCompressor(level=_LEVEL).compress
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._new: list[McapRecord] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._counts: dict[int, int] = {}
        self._write(MAGIC)
        self._write(_bytes_of([Header(profile, "doorman")]))

    def add_metadata(self, name: str, entries: Mapping[str, str]) -> None:
        data = _bytes_of([Metadata(name=name, metadata=dict(entries))])
        self._metadata.append(MetadataIndex(offset=self._place, length=len(data), name=name))
        self._write(data)

    def add_attachment(self, name: str, media_type: str, content: bytes) -> None:
        data = _bytes_of([Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=content)])
        index = AttachmentIndex(
            offset=self._place, length=len(data), create_time=0, log_time=0, data_size=len(content), name=name,
            media_type=media_type,
        )  # fmt: skip
        self._attachments.append(index)
        self._write(data)

    def add_channel(self, topic: str, message_encoding: str, schema: tuple[str, str, bytes]) -> int:
        """Make a topic known; it is written with the next chunk."""
        number = len(self._channels) + 1
        name, encoding, data = schema
        self._schemas.append(Schema(id=number, data=data, encoding=encoding, name=name))
        channel = Channel(
            id=number, topic=topic, message_encoding=message_encoding, schema_id=number, metadata={}
        )  # fmt: skip
        self._channels.append(channel)
        self._new += [self._schemas[-1], channel]
        return number

    def add_chunk(self, messages: Sequence[tuple[int, Framed]]) -> None:
        """Write messages as one chunk, with their index."""
        new, self._new = _bytes_of(self._new), []
        content = b"".join((new, *(framed.data for _, framed in messages)))
        start = min(int(framed.times.min()) for _, framed in messages)
        end = max(int(framed.times.max()) for _, framed in messages)
        data = self._compress(content)
        chunk = _bytes_of(
            [Chunk(compression=COMPRESSION, data=data, message_start_time=start, message_end_time=end,
                   uncompressed_crc=zlib.crc32(content), uncompressed_size=len(content))]
        )  # fmt: skip
        index = ChunkIndex(
            message_start_time=start, message_end_time=end, chunk_start_offset=self._place, chunk_length=len(chunk),
            message_index_offsets={}, message_index_length=0, compression=COMPRESSION, compressed_size=len(data),
            uncompressed_size=len(content),
        )  # fmt: skip
        self._write(chunk)
        before, place = self._place, len(new)
        for channel, framed in messages:
            index.message_index_offsets[channel] = self._place
            self._write(_message_index(channel, framed, place))
            self._counts[channel] = self._counts.get(channel, 0) + len(framed.times)
            place += len(framed.data)
        index.message_index_length = self._place - before
        self._chunks.append(index)

    def finish(self) -> None:
        self._write(_bytes_of([DataEnd(0)]))
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, [*self._schemas]), (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [self._statistics()]), (Opcode.CHUNK_INDEX, [*self._chunks]),
            (Opcode.ATTACHMENT_INDEX, [*self._attachments]), (Opcode.METADATA_INDEX, [*self._metadata]),
        ]  # fmt: skip
        start, summary, offsets = self._place, b"", []
        for opcode, records in groups:
            data = _bytes_of(records)
            offsets.append(SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(data)))
            summary += data
        offset_start = start + len(summary)
        summary += _bytes_of(offsets)
        covered = summary + _FOOTER.pack(Opcode.FOOTER, 20, start, offset_start)
        footer = Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=zlib.crc32(covered))
        self._write(summary + _bytes_of([footer]) + MAGIC)

    def _statistics(self) -> Statistics:
        chunks = self._chunks
        return Statistics(
            attachment_count=len(self._attachments), channel_count=len(self._channels),
            channel_message_counts=self._counts, chunk_count=len(chunks), message_count=sum(self._counts.values()),
            metadata_count=len(self._metadata), schema_count=len(self._schemas),
            message_start_time=min((chunk.message_start_time for chunk in chunks), default=0),
            message_end_time=max((chunk.message_end_time for chunk in chunks), default=0),
        )  # fmt: skip

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._place += len(data)


def _bytes_of(records: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def _message_index(channel: int, framed: Framed, place: int) -> bytes:
    """Times and places of a topic's messages in a chunk, where the first of them begins at `place`."""
    entries = np.empty((len(framed.times), 2), dtype="<u8")
    entries[:, 0], entries[:, 1] = framed.times, framed.places
    entries[:, 1] += np.uint64(place)
    head = _INDEX.pack(Opcode.MESSAGE_INDEX, _INDEX.size - 9 + entries.nbytes, channel, entries.nbytes)
    return head + entries.tobytes()
