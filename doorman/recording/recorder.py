"""Recorder: writes what simulation and flight alike report, into an MCAP file that survives a crash, or into memory.

Messages are gathered for a tenth of a second of their own time, or until they are many, and then written out as one chunk: what a
killed process loses is less than that. A thread has the disk take what was written; a power cut costs little more. Messages are
encoded one by one, and batches are written with SIGINT, SIGTERM and SIGHUP held back, so Ctrl-C never
leaves half a message. What is in the file is read back from there; only what no file takes stays in memory.
"""

from __future__ import annotations

import json
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, TypeAlias

from mcap.writer import Writer

from doorman.bounds import LARGEST_CHUNK, LAST_TIME
from doorman.copying import Uncopied
from doorman.exceptions import RecordingError
from doorman.recording.files.cdr import type_name
from doorman.recording.files.disk import Syncer, claimed_stream, is_regular, sync_folder
from doorman.recording.files.header import HEADER, header_json, header_schema, header_text
from doorman.recording.files.held_signals import signals_held_back
from doorman.recording.files.messages import Columns, MessageType, Value, joined, time_of
from doorman.recording.files.reading import TOPIC, Contents, read_contents
from doorman.recording.recording import Recording, Topic

Listener: TypeAlias = Callable[[str, float, Mapping[str, Value]], None]
"""Called with topic, time and fields of every message, as soon as it is recorded."""

_BATCH_TIME = 0.1
"""Longest stretch of message time that waits in memory [s]."""
_MOST_BYTES = 1_000_000
"""Most that waits there."""
_PORTION = 16
"""Messages that are framed at once: a tick of the controller waits for no more of them."""
_PROFILE = "x-doorman"
_MEDIA_TYPES = {".urdf": "application/xml", ".stl": "model/stl", ".obj": "model/obj", ".dae": "model/vnd.collada+xml"}


class _Channel:
    def __init__(self, type_: MessageType) -> None:
        self.type = type_
        self.number: int | None = None  # in the file
        self.kept: list[Columns] = []  # what no file has taken


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
        self._batch: list[tuple[_Channel, bytes]] = []  # messages that the operating system does not have yet
        self._framed = 0  # so many of them are in the writer's chunk
        self._batch_start, self._batch_size = 0.0, 0  # [s], [bytes]
        self._listener, self._keeps = listener, keep
        self._closed = False
        self._error: OSError | None = None
        self._stream: IO[bytes] | None = None
        self._writer: Writer | None = None
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
        message = channel.type.encode(time, fields)
        self._channels[topic] = channel
        if not self._batch:
            self._batch_start, self._batch_size = time, 0
        self._batch.append((channel, message))
        self._batch_size += len(message)
        late = self._writer is not None and abs(time - self._batch_start) >= _BATCH_TIME
        if late or self._batch_size > _MOST_BYTES:
            self.flush()
        elif self._writer is not None and len(self._batch) - self._framed >= _PORTION:
            with signals_held_back(), self._errors_remembered():
                self._frame()
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
                    self._writer.finish()  # type: ignore[no-untyped-call]
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
            if channel.kept:  # the recording shares one block, and needs no memory of its own
                channel.kept = [joined(channel.kept)]
                blocks.setdefault(name, []).extend(channel.kept)
        topics = {name: Topic(name, *joined(parts)) for name, parts in blocks.items()}
        whole = self._error is None and not found.damaged_chunks
        return Recording(topics, self.header, whole, attachments=self._attachments, damaged_chunks=found.damaged_chunks)

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
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
            self._writer = writer = Writer(self._stream, chunk_size=LARGEST_CHUNK)  # it ends chunks when it is told
            writer.start(_PROFILE, "doorman")
            writer.add_metadata(HEADER, {k: header_text(v) for k, v in self.header.items()})
            for name, data in self._attachments.items():
                kind = _MEDIA_TYPES.get(Path(name).suffix.lower(), "application/octet-stream")
                writer.add_attachment(0, 0, name, kind, data)
            schema = writer.register_schema(HEADER, "jsonschema", json.dumps(header_schema(self.header)).encode())
            writer.add_message(writer.register_channel(HEADER, "json", schema), 0, header.encode(), 0)
            self._hand_over()

    def _new_channel(self, topic: str, fields: Mapping[str, Value]) -> _Channel:
        if topic == HEADER:
            raise RecordingError("the topic is taken by the recording's header", field="topic", given=topic)
        type_ = MessageType.of(topic, fields)
        if type_.size > LARGEST_CHUNK // 2:
            raise RecordingError("too large a message", field=topic, allowed=f"up to {LARGEST_CHUNK // 2} bytes")
        return _Channel(type_)

    def _hand_over(self) -> None:
        """Hand what was gathered to the operating system, and have the disk take it soon."""
        if self._writer is not None:
            self._frame()
            self._writer.flush()  # type: ignore[no-untyped-call]
        if self._writer is None or self._stream is None or self._syncer is None:
            self._keep_batch()  # memory, or a device, from which nothing is read back
            return
        self._written = self._stream.tell()
        self._batch, self._framed = [], 0
        self._syncer.request()

    def _frame(self) -> None:
        """Put what waits into the writer's chunk."""
        assert self._writer is not None
        for channel, message in self._batch[self._framed :]:
            if channel.number is None:
                channel.number = self._register(self._writer, channel.type)
            nanoseconds = round(1e9 * time_of(message))
            self._writer.add_message(channel.number, nanoseconds, message, nanoseconds)
        self._framed = len(self._batch)

    @staticmethod
    def _register(writer: Writer, type_: MessageType) -> int:
        """Make a topic known to the file; its schema stands there twice."""
        topic, schema = type_.topic, type_.schema()
        described = writer.register_schema(type_name(topic), "ros2msg", schema.encode())
        number: int = writer.register_channel(topic, "cdr", described)
        writer.add_metadata(TOPIC, {"id": str(number), "topic": topic, "schema": schema})
        return number

    def _keep_batch(self) -> None:
        """Keep in memory what the file has not taken."""
        waiting: dict[_Channel, list[bytes]] = {}
        for channel, message in self._batch if self._keeps else ():
            waiting.setdefault(channel, []).append(message)
        for channel, messages in waiting.items():
            channel.kept.append(channel.type.columns(messages))
        self._batch, self._framed = [], 0

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
