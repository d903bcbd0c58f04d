"""Reading an MCAP file that doorman wrote, also where it was cut off or damaged: what is whole is read.

A chunk counts as whole if its checksum fits. Behind a record that makes no sense, reading goes on at the next whole chunk. A
message that is not of its topic's type, or has no time, is left out and counted.
Every topic's schema stands in the chunk of its first message, in a metadata record, and in the file's summary: the loss of one
costs no other chunk.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import IO, Any

from mcap.records import Attachment, Channel, Chunk, DataEnd, McapRecord, Message, Metadata, Schema, Statistics
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC as MAGIC

from doorman.bounds import LARGEST_LOG
from doorman.exceptions import RecordingError
from doorman.recording.files.header import HEADER, header_value
from doorman.recording.files.messages import Columns, MessageType, joined
from doorman.recording.files.records import COMPRESSION, whole_record

TOPIC = "topic"
"""Name of the metadata record that repeats a topic's schema."""

_PREFIX = struct.Struct("<BQ")
"""Opcode and length of a record."""
_COMPRESSION = struct.pack("<I", len(COMPRESSION)) + COMPRESSION.encode()
_BEFORE_COMPRESSION = _PREFIX.size + 28
"""Bytes of a chunk's record before the name of its compression."""
_FOOTER = _PREFIX.size + 20
"""Size of the footer's record [bytes]."""
_BLOCK = 1 << 20
"""Read at once in the search for a chunk [bytes]."""


@dataclass
class Contents:
    header: dict[str, Any] | None = None
    topics: dict[str, Columns] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    damaged_chunks: int = 0  # chunks that could not be read, behind which others could, or that the summary counts
    damaged_messages: dict[str, int] = field(default_factory=dict)  # messages that were left out, by topic
    complete: bool = False  # whether the file ends as it should, and nothing of it is damaged


@dataclass
class _Known:
    """A topic's name and type, and what was read of it."""

    topic: str
    type: MessageType | RecordingError | None  # none for the header; the error for what doorman has not written
    blocks: list[Columns] = field(default_factory=list)  # chunk by chunk


def read_contents(stream: IO[bytes], size: int | None = None) -> Contents:
    """Read whatever is whole in a file."""
    return _Reader(stream, stream.seek(0, 2) if size is None else size).read()


class _Reader:
    def __init__(self, stream: IO[bytes], size: int) -> None:
        self._stream, self._size = stream, size
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, _Known] = {}
        self._found = Contents()
        self._chunks = self._messages = self._bad = self._content = 0
        self._foreign: RecordingError | None = None

    def read(self) -> Contents:
        found = self._found
        if self._bytes(0, len(MAGIC)) != MAGIC:
            return found
        summary = self._summary()
        ended = False
        for record in self._records():
            ended = isinstance(record, DataEnd)
            self._take(record)
        if found.header is not None and self._foreign is not None:
            raise self._foreign
        found.topics = {known.topic: joined(known.blocks) for known in self._channels.values() if known.blocks}
        found.damaged_chunks = self._bad
        if summary is not None:
            found.damaged_chunks = max(self._bad, summary.chunk_count - self._chunks)
            whole = (self._messages, len(found.attachments)) == (summary.message_count, summary.attachment_count)
            found.complete = ended and whole and not found.damaged_chunks and not found.damaged_messages
        return found

    # ---------------------------------------------------------------- records

    def _records(self) -> Iterator[McapRecord]:
        """Records of the data section, as far as they make sense."""
        place: int | None = len(MAGIC)
        while place is not None and place < self._size:
            record, end = self._record(place)
            if record is not None:
                yield record
                if isinstance(record, DataEnd):
                    return
                place = end
            else:  # on where it says that it ends, or else at the next whole chunk
                place = end if end is not None and self._record(end)[0] is not None else self._next_chunk(place + 1)
                self._bad += place is not None  # else it was cut off here

    def _record(self, place: int) -> tuple[McapRecord | None, int | None]:
        """The record at a place, if it is whole, and where it says that it ends, if the file is as long."""
        prefix = self._bytes(place, _PREFIX.size)
        if len(prefix) < _PREFIX.size:
            return None, None
        opcode, length = _PREFIX.unpack(prefix)
        end = place + _PREFIX.size + length
        if end > self._size:
            return None, None
        return whole_record(opcode, self._bytes(place + _PREFIX.size, length)), end

    def _next_chunk(self, place: int) -> int | None:
        """Where the next whole chunk begins."""
        while place < self._size:
            block = self._bytes(place, _BLOCK)
            at = block.find(_COMPRESSION)
            while at >= 0:
                start = place + at - _BEFORE_COMPRESSION
                if start >= len(MAGIC) and isinstance(self._record(start)[0], Chunk):
                    return start
                at = block.find(_COMPRESSION, at + 1)
            place += max(len(block) - len(_COMPRESSION) + 1, 1)
        return None

    def _bytes(self, place: int, length: int) -> bytes:
        self._stream.seek(place)
        return self._stream.read(max(min(length, self._size - place), 0))

    # ---------------------------------------------------------------- what they hold

    def _take(self, record: McapRecord) -> None:
        if isinstance(record, Attachment):
            self._found.attachments[record.name] = record.data
        elif isinstance(record, Metadata):
            self._take_metadata(record)
        elif isinstance(record, Chunk):
            self._content += len(record.data)
            try:
                if self._content > LARGEST_LOG:
                    raise ValueError("more than a recording holds")
                self._take_chunk(record)
            except (RecordingError, OSError):
                raise
            except Exception:  # its checksum fits, and yet it holds no messages of ours
                self._bad += 1

    def _take_metadata(self, record: Metadata) -> None:
        try:
            if record.name == HEADER and self._found.header is None:
                self._found.header = {key: header_value(text) for key, text in record.metadata.items()}
            elif record.name == TOPIC:
                number, topic, schema = (record.metadata[key] for key in ("id", "topic", "schema"))
                self._learn(int(number), topic, schema.encode())
        except (KeyError, ValueError):
            return  # a second copy

    def _take_chunk(self, chunk: Chunk) -> None:
        messages: dict[int, list[bytes]] = {}
        for record in breakup_chunk(chunk):
            if not isinstance(record, Message):
                self._learn_channel(record)
            elif record.channel_id in self._channels:
                messages.setdefault(record.channel_id, []).append(record.data)
        for number, block in messages.items():
            known = self._channels[number]
            if known.type is None:
                self._found.header = dict(json.loads(block[-1]))
            elif isinstance(known.type, RecordingError):
                self._foreign = known.type
            else:
                good = [one for one in block if known.type.fits(one)]
                if lost := len(block) - len(good):
                    self._found.damaged_messages[known.topic] = self._found.damaged_messages.get(known.topic, 0) + lost
                if good:
                    known.blocks.append(known.type.columns(good))
            self._messages += len(block)
        self._chunks += 1

    def _learn_channel(self, record: McapRecord) -> None:
        """Take in a schema, or a channel, whose schema stands before it."""
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            schema = self._schemas.get(record.schema_id)
            self._learn(record.id, record.topic, b"{}" if schema is None else schema.data)

    def _learn(self, number: int, topic: str, schema: bytes) -> None:
        if number in self._channels:
            return
        type_: MessageType | RecordingError | None = None
        if topic != HEADER:
            try:
                type_ = MessageType.from_schema(topic, schema)
            except RecordingError as error:
                type_ = error
        self._channels[number] = _Known(topic, type_)

    def _summary(self) -> Statistics | None:
        """Statistics of a file that was closed; topics that it names are known from then on."""
        end = self._bytes(max(self._size - _FOOTER - len(MAGIC), 0), _FOOTER + len(MAGIC))
        statistics = None
        try:
            footer: Any = next(StreamReader(BytesIO(end), skip_magic=True).records)
            data = self._bytes(footer.summary_start, self._size - len(end) - footer.summary_start) + end
            if zlib.crc32(data[: -len(MAGIC) - 4]) != footer.summary_crc:
                return None
            for record in StreamReader(BytesIO(data), skip_magic=True).records:
                self._learn_channel(record)
                statistics = record if isinstance(record, Statistics) else statistics
        except Exception:  # parsers raise whatever they meet
            return None
        return statistics
