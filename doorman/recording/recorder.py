"""Recorder: writes what simulation and flight alike report, into an MCAP file that survives a crash, or into memory.

Messages are gathered for a tenth of a second of their own time, or until a topic's rows are full, and then written out: what a
killed process loses is less than that. A thread has the disk take what was written; a power cut costs little more. A message
counts once its row is whole, and batches are written with SIGINT, SIGTERM and SIGHUP held back, so Ctrl-C never
leaves half a message. What is in the file is read back from there; only what no file takes stays in memory.
"""

from __future__ import annotations

import json
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import IO, Any, TypeAlias

from doorman.bounds import LARGEST_CHUNK, LAST_TIME
from doorman.copying import Uncopied
from doorman.exceptions import RecordingError
from doorman.recording.files.cdr import type_name
from doorman.recording.files.disk import Syncer, claimed_stream, is_regular, sync_folder
from doorman.recording.files.held_signals import signals_held_back
from doorman.recording.files.mcap_file import McapFile
from doorman.recording.files.messages import (
    HEADER,
    Columns,
    MessageType,
    Value,
    header_json,
    header_schema,
    header_text,
    joined,
)
from doorman.recording.files.reading import TOPIC, Contents, read_contents
from doorman.recording.files.rows import Framed, Rows
from doorman.recording.recording import Recording, Topic

Listener: TypeAlias = Callable[[str, float, Mapping[str, Value]], None]
"""Called with topic, time and fields of every message, as soon as it is recorded."""

_BATCH_TIME = 0.1
"""Longest stretch of message time that waits in memory [s]."""
_PROFILE = "x-doorman"
_MEDIA_TYPES = {".urdf": "application/xml", ".stl": "model/stl", ".obj": "model/obj", ".dae": "model/vnd.collada+xml"}


class _Channel:
    def __init__(self, type_: MessageType) -> None:
        self.rows = Rows(type_)  # what waits to be written
        self.kept: list[Columns] = []  # what no file has taken
        self.file_id: int | None = None

    def recorded(self) -> list[Columns]:
        """What is in memory."""
        return [*self.kept, self.rows.columns()] if self.rows else self.kept[:]

    def join(self) -> None:
        """Let one block take the place of the many that are kept: a recording shares it, and needs no memory of its own."""
        if self.kept:
            self.kept = [joined(self.kept)]


class Recorder(Uncopied):
    """Writes messages; used by one thread.

    Args:
        path: MCAP file to write; its directory is made, an older file is replaced. None: keep in memory only.
        header: What was run: scenario, versions, seed. Values that JSON can hold, arrays and paths.
        listener: Called with every message, on the thread that writes it.
        keep: Whether `recording` will be read: messages that no file takes stay in memory then, all of them without a path.
        attachments: Files that the recording carries, by name.

    Raises:
        RecordingError: if the file cannot be opened, another recorder writes to it, or the header holds something that JSON
            cannot.
    """

    def __init__(
        self,
        path: Path | None,
        header: Mapping[str, Any],
        listener: Listener | None = None,
        *,
        keep: bool = True,
        attachments: Mapping[str, bytes] | None = None,
    ) -> None:
        self.path = None if path is None else Path(path)
        self._file = None if path is None else Path(path).absolute()
        text = header_json(header)
        self.header: dict[str, Any] = json.loads(text)
        self._attachments = dict(attachments or {})
        self._channels: dict[str, _Channel] = {}
        self._waiting: dict[str, _Channel] = {}  # topics with messages that are to be written
        self._batch_start = 0.0
        self._listener, self._keeps = listener, keep
        self._closed = False
        self._error: OSError | None = None
        self._stream: IO[bytes] | None = None
        self._writer: McapFile | None = None
        self._syncer: Syncer | None = None
        self._written = 0  # so much of the file is whole [bytes]
        if self.path is not None:
            self._open(self.path, text)

    def write(self, topic: str, time: float, fields: Mapping[str, Value]) -> None:
        """Record one message.

        The first message of a topic fixes the names, types and shapes of its fields. Values are copied.

        Args:
            topic: Name of the topic.
            time: Time of the message, at least 0 [s].
            fields: Numbers, texts, and arrays of them, by name. NaN and infinities are kept.

        Raises:
            RecordingError: if the fields differ from those of the topic's first message, a value cannot be recorded, the
                time is negative or not finite, or the recorder is closed. A full disk does not raise here but in `close`.
        """
        if self._closed:
            raise RecordingError("the recorder is closed", file=self.path, field=topic)
        time = float(time)
        if not 0.0 <= time <= LAST_TIME:
            raise RecordingError("not a time", field=f"{topic}.time", given=time, allowed=f"0 to {LAST_TIME:g} s")
        channel = self._channels.get(topic) or self._new_channel(topic, fields)
        if not self._waiting:
            self._batch_start = time
        self._waiting[topic] = channel
        full = channel.rows.add(time, fields)
        self._channels[topic] = channel
        if full or (self._writer is not None and abs(time - self._batch_start) >= _BATCH_TIME):
            self.flush()
        if self._listener is not None:
            self._listener(topic, time, fields)

    def flush(self) -> None:
        """Hand everything written so far to the operating system; `write` calls it often enough by itself."""
        with signals_held_back(), self._errors_remembered():
            self._hand_over()

    def close(self) -> None:
        """Write what is left, have the disk take it, and close the file; may be called twice.

        Raises:
            RecordingError: once, if the file could not be written to the end, now or earlier. What the file does not hold is
                still in memory, unless `keep` was false.
        """
        if self._closed:
            return
        with signals_held_back():
            self._closed = True
            with self._errors_remembered():
                self._hand_over()
                if self._writer is not None and self._stream is not None:
                    self._writer.finish()
                    self._stream.flush()
                    if self._syncer is not None:
                        self._written = self._stream.tell()
                        self._syncer.sync()
                    self._stream.close()
            self._writer = None
            if self._syncer is not None:
                self._syncer.stop()
        if self._error is not None:
            raise RecordingError(
                f"the recording is incomplete: {self._error.strerror or self._error}", file=self.path
            ) from self._error

    def recording(self) -> Recording:
        """Everything recorded so far, read back from the file, if there is one; later messages do not show in it.

        Raises:
            RecordingError: if `keep` was false, or the file cannot be read any more.
        """
        if not self._keeps:
            raise RecordingError("the recording is not kept in memory; read the file", file=self.path)
        if not self._closed:
            self.flush()
        found = self._read_back()
        blocks = {topic: [columns] for topic, columns in found.topics.items()}
        for name, channel in list(self._channels.items()):
            channel.join()
            if parts := channel.recorded():
                blocks.setdefault(name, []).extend(parts)
        topics = {name: Topic(name, *joined(parts)) for name, parts in blocks.items()}
        whole = self._error is None and not found.damaged_chunks
        return Recording(topics, self.header, whole, attachments=self._attachments, damaged_chunks=found.damaged_chunks)

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        try:
            self.close()
        except RecordingError as failure:
            if error is None:
                raise
            error.add_note(str(failure))  # the first error is the one to report

    def _open(self, path: Path, header: str) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._stream = claimed_stream(path)
        except BlockingIOError as error:
            raise RecordingError("another recorder writes to this file", file=path) from error
        except OSError as error:
            raise RecordingError(f"cannot be written: {error.strerror}", file=path) from error
        with signals_held_back(), self._errors_remembered():
            if is_regular(self._stream):
                self._syncer = Syncer(self._stream.fileno())
                weakref.finalize(self, self._syncer.stop)
                sync_folder(path.parent)
            self._writer = writer = McapFile(self._stream, _PROFILE)
            writer.add_metadata(HEADER, {k: header_text(v) for k, v in self.header.items()})
            for name, data in self._attachments.items():
                kind = _MEDIA_TYPES.get(Path(name).suffix.lower(), "application/octet-stream")
                writer.add_attachment(name, kind, data)
            schema = json.dumps(header_schema(self.header)).encode()
            channel = writer.add_channel(HEADER, "json", (HEADER, "jsonschema", schema))
            writer.add_chunk([(channel, Framed.of(channel, header.encode()))])
            self._hand_over()

    def _new_channel(self, topic: str, fields: Mapping[str, Value]) -> _Channel:
        if topic == HEADER:
            raise RecordingError("the topic is taken by the recording's header", field="topic", given=topic)
        type_ = MessageType.of(topic, fields)
        if type_.layout.dtype().itemsize > LARGEST_CHUNK // 2:
            raise RecordingError("too large a message", field=topic, allowed=f"up to {LARGEST_CHUNK // 2} bytes")
        return _Channel(type_)

    def _hand_over(self) -> None:
        """Hand what was gathered to the operating system, and have the disk take it soon."""
        self._write_batch()
        if self._writer is None or self._stream is None or self._syncer is None:
            self._keep_batch()  # memory, or a device, from which nothing is read back
            return
        self._stream.flush()
        self._written = self._stream.tell()
        self._clear_batch()
        self._syncer.request()

    def _write_batch(self) -> None:
        if self._writer is None:
            return
        batch = []
        for channel in (each for each in self._waiting.values() if each.rows):
            if channel.file_id is None:
                channel.file_id = self._register(self._writer, channel.rows.type)
            batch.append((channel.file_id, channel.rows.framed(channel.file_id)))
        if batch:
            self._writer.add_chunk(batch)

    @staticmethod
    def _register(writer: McapFile, type_: MessageType) -> int:
        """Make a topic known to the file; its schema stands there twice."""
        topic, schema = type_.topic, type_.schema()
        number = writer.add_channel(topic, "cdr", (type_name(topic), "ros2msg", schema.encode()))
        writer.add_metadata(TOPIC, {"id": str(number), "topic": topic, "schema": schema})
        return number

    def _keep_batch(self) -> None:
        """Keep in memory what the file has not taken."""
        if self._keeps:
            for channel in self._waiting.values():
                channel.kept = channel.recorded()
                channel.rows.clear()
        self._clear_batch()

    def _clear_batch(self) -> None:
        for channel in self._waiting.values():
            channel.rows.clear()
        self._waiting.clear()

    def _read_back(self) -> Contents:
        """What the file holds that was handed over whole."""
        if self._file is None or self._written == 0:
            return Contents()
        try:
            with self._file.open("rb") as stream:
                return read_contents(stream, self._written)
        except OSError as error:
            raise RecordingError(f"cannot be read back: {error.strerror}", file=self._file) from error

    @contextmanager
    def _errors_remembered(self) -> Iterator[None]:
        """Stop writing at the first failure of the file, and keep it for `close`."""
        try:
            yield
        except OSError as error:
            self._error = error
            self._writer = None
            self._keep_batch()
            try:
                if self._stream is not None:
                    self._stream.close()
            except OSError:
                pass  # the same failure again, as its buffer is written out
