"""Reading an MCAP file that doorman wrote, also where it was cut off or damaged: what is whole is read.

A chunk counts as whole if its checksum fits. Behind a record that makes no sense, reading goes on at the next whole chunk.
Every topic's schema stands in the chunk of its first message, in a metadata record, and in the file's summary: the loss of one
costs no other chunk.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from typing import IO, Any, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Message, Metadata, Schema, Statistics
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC as MAGIC

from doorman.exceptions import RecordingError
from doorman.recording.messages import HEADER, Columns, MessageType, Row, joined

TOPIC = "topic"
"""Name of the metadata record that repeats a topic's schema."""

_PREFIX = struct.Struct("<BQ")
"""Opcode and length of a record."""
_COMPRESSION = b"\x03\x00\x00\x00lz4"
_BEFORE_COMPRESSION = _PREFIX.size + 28
"""Bytes of a chunk's record before the name of its compression."""
_FOOTER = struct.Struct("<BQQQI")
_BLOCK = 1 << 20
"""Read at once in the search for a chunk [bytes]."""
_IGNORED = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.HEADER)
"""Records outside chunks that hold nothing that is needed from there."""


@dataclass
class Contents:
    """What could be read of a file."""

    header: dict[str, Any] | None = None
    topics: dict[str, Columns] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    damaged_chunks: int = 0
    """Chunks that could not be read, behind which others could, or that the summary counts."""
    complete: bool = False
    """Whether the file ends as it should, and nothing of it is damaged."""


class _Record(NamedTuple):
    opcode: int
    content: bytes
    end: int
    """Where the next one begins [bytes]."""

    def parsed(self) -> Any:
        """What it holds; None if it is none that doorman writes outside chunks, or is damaged as far as can be told."""
        try:
            return _parsed(self.opcode, self.content)
        except Exception:  # parsers raise whatever they stumble over
            return None


class _Known(NamedTuple):
    """A topic's name and type."""

    topic: str
    type: MessageType | RecordingError | None
    """None for the header; the error for what doorman has not written."""


def read_contents(stream: IO[bytes], size: int | None = None) -> Contents:
    """Read whatever is whole in a file.

    Args:
        stream: The file, open for reading.
        size: How much of it to read; all by default [bytes].

    Returns:
        The contents; without a header if it is not a file of doorman's.

    Raises:
        RecordingError: if a topic of doorman's file was not written by doorman.
        OSError: if the file cannot be read.
    """
    return _Reader(stream, stream.seek(0, 2) if size is None else size).read()


class _Reader:
    def __init__(self, stream: IO[bytes], size: int) -> None:
        self._stream, self._size = stream, size
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, _Known] = {}
        self._blocks: dict[str, list[Columns]] = {}
        self._found = Contents()
        self._whole = self._messages = self._bad = 0
        self._foreign: RecordingError | None = None

    def read(self) -> Contents:
        found = self._found
        if self._bytes(0, len(MAGIC)) != MAGIC:
            return found
        summary = self._summary()
        ended = False
        for opcode, parsed in self._records():
            ended = opcode == Opcode.DATA_END
            self._take(opcode, parsed)
        if found.header is not None and self._foreign is not None:
            raise self._foreign
        found.topics = {topic: joined(blocks) for topic, blocks in self._blocks.items()}
        found.damaged_chunks = self._bad
        if summary is not None:
            found.damaged_chunks = max(self._bad, summary.chunk_count - self._whole)
            all_there = self._messages == summary.message_count
            all_there &= len(found.attachments) == summary.attachment_count
            found.complete = ended and self._bad == 0 and found.damaged_chunks <= 0 and all_there
        found.damaged_chunks = max(found.damaged_chunks, 0)
        return found

    # ---------------------------------------------------------------- records

    def _records(self) -> Iterator[tuple[int, Any]]:
        """Opcode and parsed content of the records of the data section, as far as they make sense."""
        place: int | None = len(MAGIC)
        while place is not None and place < self._size:
            record = self._record(place)
            parsed = None if record is None else record.parsed()
            if record is not None and parsed is not None:
                yield record.opcode, parsed
                if record.opcode == Opcode.DATA_END:
                    return
                place = record.end
            else:
                place = self._after_damage(place, record)
                self._bad += place is not None  # else it was cut off here

    def _after_damage(self, place: int, record: _Record | None) -> int | None:
        """Where to go on behind a record that makes no sense: where it says that it ends, or else at the next whole chunk."""
        follows = None if record is None else self._record(record.end)
        if record is not None and follows is not None and follows.parsed() is not None:
            return record.end
        return self._next_chunk(place + 1)

    def _record(self, place: int) -> _Record | None:
        """The record at a place; None if none fits there."""
        prefix = self._bytes(place, _PREFIX.size)
        if len(prefix) < _PREFIX.size:
            return None
        opcode, length = _PREFIX.unpack(prefix)
        end = place + _PREFIX.size + length
        return _Record(opcode, self._bytes(place + _PREFIX.size, length), end) if end <= self._size else None

    def _next_chunk(self, place: int) -> int | None:
        """Where the next whole chunk begins."""
        while place < self._size:
            block = self._bytes(place, _BLOCK)
            at = block.find(_COMPRESSION)
            while at >= 0:
                start = place + at - _BEFORE_COMPRESSION
                record = self._record(start) if start >= len(MAGIC) else None
                if record is not None and record.opcode == Opcode.CHUNK and record.parsed() is not None:
                    return start
                at = block.find(_COMPRESSION, at + 1)
            place += max(len(block) - len(_COMPRESSION) + 1, 1)
        return None

    def _bytes(self, place: int, length: int) -> bytes:
        self._stream.seek(place)
        return self._stream.read(max(min(length, self._size - place), 0))

    # ---------------------------------------------------------------- what they hold

    def _take(self, opcode: int, parsed: Any) -> None:
        if opcode == Opcode.CHUNK:
            try:
                self._take_chunk(parsed)
            except (RecordingError, OSError):
                raise
            except (
                Exception
            ):  # its checksum fits, and yet it holds no messages of ours: parsers raise whatever they meet
                self._bad += 1
        elif opcode == Opcode.ATTACHMENT:
            self._found.attachments[parsed.name] = parsed.data
        elif opcode == Opcode.METADATA:
            self._take_metadata(parsed)

    def _take_metadata(self, record: Metadata) -> None:
        try:
            if record.name == HEADER and self._found.header is None:
                self._found.header = {key: header_value(text) for key, text in record.metadata.items()}
            elif record.name == TOPIC:
                number, topic, schema = (record.metadata[key] for key in ("id", "topic", "schema"))
                self._learn(int(number), topic, schema.encode())
        except (KeyError, ValueError):
            return  # a second copy

    def _take_chunk(self, records: Sequence[Any]) -> None:
        rows: dict[str, tuple[MessageType, list[Row]]] = {}
        header, count = None, 0
        for record in records:
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._learn_channel(record)
            elif isinstance(record, Message) and (known := self._channels.get(record.channel_id)) is not None:
                count += 1
                if isinstance(known.type, MessageType):
                    rows.setdefault(known.topic, (known.type, []))[1].append(known.type.decode(record.data))
                elif known.type is None:
                    header = dict(json.loads(record.data))
                else:
                    self._foreign = known.type
        blocks = {topic: type_.columns(block) for topic, (type_, block) in rows.items()}
        for topic, columns in blocks.items():
            self._blocks.setdefault(topic, []).append(columns)
        self._found.header = self._found.header if header is None else header
        self._messages += count
        self._whole += 1

    def _learn_channel(self, channel: Channel) -> None:
        schema = self._schemas.get(channel.schema_id)
        self._learn(channel.id, channel.topic, b"{}" if schema is None else schema.data)

    def _learn(self, number: int, topic: str, schema: bytes) -> None:
        if number not in self._channels:
            self._channels[number] = _Known(topic, None if topic == HEADER else _type(topic, schema))

    def _summary(self) -> Statistics | None:
        """Statistics of a file that was closed; topics that it names are known from then on."""
        start = self._size - len(MAGIC) - _FOOTER.size
        end = self._bytes(start, _FOOTER.size + len(MAGIC)) if start > 0 else b""
        if len(end) != _FOOTER.size + len(MAGIC) or not end.endswith(MAGIC):
            return None
        opcode, length, place, _, checksum = _FOOTER.unpack_from(end)
        if (opcode, length) != (Opcode.FOOTER, _FOOTER.size - _PREFIX.size) or not len(MAGIC) <= place < start:
            return None
        if checksum and zlib.crc32(self._bytes(place, start - place) + end[: _FOOTER.size - 4]) != checksum:
            return None
        statistics = None
        while place < start and (record := self._record(place)) is not None:
            if record.opcode == Opcode.SCHEMA:
                schema = Schema.read(_stream_of(record.content))
                self._schemas[schema.id] = schema
            elif record.opcode == Opcode.CHANNEL:
                self._learn_channel(Channel.read(_stream_of(record.content)))
            elif record.opcode == Opcode.STATISTICS:
                statistics = Statistics.read(_stream_of(record.content))
            place = record.end
        return statistics


def _type(topic: str, schema: bytes) -> MessageType | RecordingError:
    try:
        return MessageType.from_schema(topic, json.loads(schema))
    except RecordingError as error:
        return error
    except ValueError:
        return RecordingError("not a schema of doorman's", field=topic, given=repr(schema[:80]))


def header_value(text: str) -> Any:
    """Value of the header from the text in its metadata record."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def header_text(value: Any) -> str:
    """Text of a value of the header: the words themselves where they are no JSON, so that they read well."""
    return value if isinstance(value, str) and header_value(value) is value else json.dumps(value)


def _parsed(opcode: int, content: bytes) -> Any:
    """What a record outside chunks holds; None or any exception if it makes no sense."""
    if opcode == Opcode.CHUNK:
        chunk = Chunk.read(_stream_of(content))
        return breakup_chunk(chunk, validate_crc=True) if chunk.uncompressed_crc else None
    if opcode == Opcode.ATTACHMENT:
        whole = zlib.crc32(content[:-4]) == int.from_bytes(content[-4:], "little")
        return Attachment.read(_stream_of(content)) if whole else None
    if opcode == Opcode.METADATA:
        stream = _stream_of(content)
        metadata = Metadata.read(stream)
        return metadata if stream.count == len(content) else None
    if opcode == Opcode.MESSAGE_INDEX:
        return int.from_bytes(content[2:6], "little") == len(content) - 6 or None
    if opcode == Opcode.DATA_END:
        return len(content) == 4 or None
    return opcode in _IGNORED or None


def _stream_of(content: bytes) -> Any:
    return ReadDataStream(BytesIO(content))
