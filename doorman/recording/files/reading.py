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
from typing import IO, Any

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema, Statistics
from mcap.writer import MCAP0_MAGIC as MAGIC

from doorman.bounds import LARGEST_LOG, LAST_TIME
from doorman.exceptions import RecordingError, shown
from doorman.recording.files.cdr import HEADER as CDR
from doorman.recording.files.mcap_file import COMPRESSION
from doorman.recording.files.messages import HEADER, Columns, MessageType, header_value
from doorman.recording.files.records import PREFIX, Record, records_of, stream_of

TOPIC = "topic"
"""Name of the metadata record that repeats a topic's schema."""

_MESSAGE = struct.Struct("<HIQQ")
"""Topic, sequence and times of a message before its data."""
_COMPRESSION = struct.pack("<I", len(COMPRESSION)) + COMPRESSION.encode()
_BEFORE_COMPRESSION = PREFIX.size + 28
"""Bytes of a chunk's record before the name of its compression."""
_TIME = struct.Struct("<d")
_FOOTER = struct.Struct("<BQQQI")
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
    size: int = 0  # of the fixed part of a message [bytes]
    rows: list[bytes] = field(default_factory=list)  # fixed parts of the messages, chunk by chunk
    tails: list[bytes] = field(default_factory=list)  # what follows each; nothing where the type has no texts
    bad: int = 0  # messages that are none of this type

    def __post_init__(self) -> None:
        if isinstance(self.type, MessageType):
            self.size = self.type.layout.dtype().itemsize
        self._known_tails: dict[bytes, bytes | None] = {}

    def take(self, messages: list[bytes]) -> None:
        """Take in those messages of one chunk that are of this type."""
        good = [one for one in messages if self._fits(one)]
        self.bad += len(messages) - len(good)
        self.rows.append(b"".join([one[: self.size] for one in good]))
        if isinstance(self.type, MessageType) and self.type.layout.texts:
            self.tails += [self._known_tails[one[self.size :]] or b"" for one in good]

    def _fits(self, message: bytes) -> bool:
        assert isinstance(self.type, MessageType)
        if len(message) < self.size or not 0.0 <= _TIME.unpack_from(message, len(CDR))[0] <= LAST_TIME:
            return False
        if not self.type.layout.texts:
            return len(message) == self.size
        tail = message[self.size :]
        if tail not in self._known_tails:  # most are like the one before
            try:
                self.type.layout.read_tail(tail)
                self._known_tails[tail] = tail
            except ValueError:
                self._known_tails[tail] = None
        return self._known_tails[tail] is not None

    def columns(self) -> Columns:
        """What was read, taken apart; at least one message."""
        assert isinstance(self.type, MessageType)
        return self.type.columns(np.frombuffer(b"".join(self.rows), self.type.layout.dtype()), self.tails)


def read_contents(stream: IO[bytes], size: int | None = None) -> Contents:
    """Read whatever is whole in a file."""
    return _Reader(stream, stream.seek(0, 2) if size is None else size).read()


class _Reader:
    def __init__(self, stream: IO[bytes], size: int) -> None:
        self._stream, self._size = stream, size
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, _Known] = {}
        self._topics: dict[str, _Known] = {}  # those with messages, in the order of the first ones
        self._found = Contents()
        self._whole = self._messages = self._bad = self._content = 0
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
        found.topics = {topic: known.columns() for topic, known in self._topics.items() if any(known.rows)}
        found.damaged_messages = {topic: known.bad for topic, known in self._topics.items() if known.bad}
        found.damaged_chunks = self._bad
        if summary is not None:
            found.damaged_chunks = max(self._bad, summary.chunk_count - self._whole)
            all_there = self._messages == summary.message_count and not found.damaged_messages
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

    def _after_damage(self, place: int, record: Record | None) -> int | None:
        """Where to go on behind a record that makes no sense: where it says that it ends, or else at the next whole chunk."""
        follows = None if record is None else self._record(record.end)
        if record is not None and follows is not None and follows.parsed() is not None:
            return record.end
        return self._next_chunk(place + 1)

    def _record(self, place: int) -> Record | None:
        """The record at a place; None if none fits there."""
        prefix = self._bytes(place, PREFIX.size)
        if len(prefix) < PREFIX.size:
            return None
        opcode, length = PREFIX.unpack(prefix)
        end = place + PREFIX.size + length
        return Record(opcode, self._bytes(place + PREFIX.size, length), end) if end <= self._size else None

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
            self._content += len(parsed)
            try:
                if self._content > LARGEST_LOG:
                    raise ValueError("more than a recording holds")
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

    def _take_chunk(self, content: bytes) -> None:
        messages: dict[int, list[bytes]] = {}
        for opcode, start, end in records_of(content):
            if opcode == Opcode.MESSAGE:
                (number, *_) = _MESSAGE.unpack_from(content, start)
                if number in self._channels:
                    messages.setdefault(number, []).append(content[start + _MESSAGE.size : end])
            elif opcode == Opcode.SCHEMA:
                schema = Schema.read(stream_of(content[start:end]))
                self._schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                self._learn_channel(Channel.read(stream_of(content[start:end])))
        for number, block in messages.items():
            known = self._channels[number]
            if isinstance(known.type, MessageType):
                known.take(block)
                self._topics.setdefault(known.topic, known)
            elif known.type is None:
                self._found.header = dict(json.loads(block[-1]))
            else:
                self._foreign = known.type
            self._messages += len(block)
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
        if (opcode, length) != (Opcode.FOOTER, _FOOTER.size - PREFIX.size) or not len(MAGIC) <= place < start:
            return None
        if checksum and zlib.crc32(self._bytes(place, start - place) + end[: _FOOTER.size - 4]) != checksum:
            return None
        statistics = None
        while place < start and (record := self._record(place)) is not None:
            try:
                if record.opcode == Opcode.SCHEMA:
                    schema = Schema.read(stream_of(record.content))
                    self._schemas[schema.id] = schema
                elif record.opcode == Opcode.CHANNEL:
                    self._learn_channel(Channel.read(stream_of(record.content)))
                elif record.opcode == Opcode.STATISTICS:
                    statistics = Statistics.read(stream_of(record.content))
            except Exception:  # a checksum of 0 is none: parsers raise whatever they meet
                return None
            place = record.end
        return statistics


def _type(topic: str, schema: bytes) -> MessageType | RecordingError:
    try:
        return MessageType.from_schema(topic, schema.decode())
    except RecordingError as error:
        return error
    except ValueError:
        return RecordingError("not a schema of doorman's", field=topic, given=shown(schema))
