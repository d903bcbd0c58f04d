"""Recorder: writes what simulation and flight alike report, into memory and into an MCAP file that survives a crash.

Messages are gathered for a tenth of a second of their own time, or until they fill a chunk, and then written out: what a
killed process loses is less than that. A message enters memory and the gathered batch by one append each, and batches
are written with SIGINT, SIGTERM and SIGHUP held back, so Ctrl-C never leaves half a message.
"""

from __future__ import annotations

import json
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, TracebackType
from typing import IO, Any, TypeAlias

import numpy as np
from mcap.writer import CompressionType, Writer

from doorman.copying import Uncopied
from doorman.exceptions import RecordingError
from doorman.recording.messages import MessageType, Row, Value
from doorman.recording.recording import HEADER, Recording, Topic

Listener: TypeAlias = Callable[[str, float, Mapping[str, Value]], None]
"""Called with topic, time and fields of every message, as soon as it is recorded."""

_BATCH_TIME = 0.1
"""Longest stretch of message time that waits in memory [s]."""
_BATCH_SIZE = 64_000
"""Most bytes that wait in memory; also the size of the file's chunks."""
_LAST_TIME = 1e10
"""MCAP counts nanoseconds in 64 bits [s]."""


class _Channel:
    """What the recorder keeps of one topic."""

    def __init__(self, type_: MessageType) -> None:
        self.type = type_
        self.rows: list[Row] = []
        self.file_id: int | None = None


class Recorder(Uncopied):
    """Writes messages; used by one thread.

    Args:
        path: MCAP file to write; its directory is made, an older file is replaced. None: keep in memory only.
        header: What was run: scenario, versions, seed. Values that JSON can hold, arrays and paths.
        listener: Called with every message, on the thread that writes it.
        keep: Whether messages stay in memory, for `recording`; what runs for hours has no room for them.

    Raises:
        RecordingError: if the file cannot be opened, or the header holds something that JSON cannot.
    """

    def __init__(
        self, path: Path | None, header: Mapping[str, Any], listener: Listener | None = None, *, keep: bool = True
    ) -> None:
        self.path = None if path is None else Path(path)
        text = _header_text(header)
        self.header: dict[str, Any] = json.loads(text)
        self._channels: dict[str, _Channel] = {}
        self._batch: list[tuple[_Channel, int, bytes]] = []
        self._batch_size = 0
        self._batch_start = 0.0
        self._listener, self._keeps = listener, keep
        self._closed = False
        self._error: OSError | None = None
        self._stream: IO[bytes] | None = None
        self._writer: Writer | None = None
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
        if not 0.0 <= time <= _LAST_TIME:
            raise RecordingError("not a time", field=f"{topic}.time", given=time, allowed=f"0 to {_LAST_TIME:g} s")
        channel = self._channels.get(topic) or self._new_channel(topic, fields)
        row = channel.type.row(time, fields)
        data = channel.type.encode(row) if self._writer is not None else b""
        self._channels[topic] = channel
        if self._keeps:
            channel.rows.append(row)
        if self._writer is not None:
            if not self._batch:
                self._batch_start = time
            self._batch.append((channel, round(time * 1e9), data))
            self._batch_size += len(data)
            if self._batch_size > _BATCH_SIZE or abs(time - self._batch_start) >= _BATCH_TIME:
                self.flush()
        if self._listener is not None:
            self._listener(topic, time, fields)

    def flush(self) -> None:
        """Hand everything written so far to the operating system; `write` calls it often enough by itself."""
        with _signals_held_back(), self._errors_remembered():
            self._write_batch()
            if self._writer is not None:
                self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Write what is left and close the file; may be called twice.

        Raises:
            RecordingError: once, if the file could not be written to the end, now or earlier. What was recorded is still
                in memory, unless `keep` was false.
        """
        if self._closed:
            return
        with _signals_held_back():
            self._closed = True
            with self._errors_remembered():
                self._write_batch()
                if self._writer is not None and self._stream is not None:
                    self._writer.finish()  # type: ignore[no-untyped-call]
                    self._stream.close()
            self._writer = None
        if self._error is not None:
            raise RecordingError(
                f"the recording is incomplete: {self._error.strerror or self._error}", file=self.path
            ) from self._error

    def recording(self) -> Recording:
        """Everything recorded so far, from memory; later messages do not show in it.

        Raises:
            RecordingError: if nothing is kept there.
        """
        if not self._keeps:
            raise RecordingError("it is not kept in memory; read the file", file=self.path)
        topics = {}
        for name, channel in list(self._channels.items()):
            rows = channel.rows[:]
            if rows:
                topics[name] = Topic(name, *channel.type.columns(rows))
        return Recording(topics, self.header, complete=self._error is None)

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

    def _open(self, path: Path, header_text: str) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._stream = path.open("wb")
        except OSError as error:
            raise RecordingError(f"cannot be written: {error.strerror}", file=path) from error
        self._writer = Writer(self._stream, chunk_size=_BATCH_SIZE, compression=CompressionType.LZ4)
        with _signals_held_back(), self._errors_remembered():
            self._writer.start(profile="doorman", library="doorman")
            self._writer.add_metadata(HEADER, {k: _metadata_text(v) for k, v in self.header.items()})
            schema = self._writer.register_schema(HEADER, "jsonschema", b'{"type":"object"}')
            channel = self._writer.register_channel(HEADER, "json", schema)
            self._writer.add_message(channel, 0, header_text.encode(), 0)
            self._writer.flush()  # type: ignore[no-untyped-call]

    def _new_channel(self, topic: str, fields: Mapping[str, Value]) -> _Channel:
        if topic == HEADER:
            raise RecordingError("the topic is taken by the recording's header", field="topic", given=topic)
        return _Channel(MessageType.of(topic, fields))

    def _write_batch(self) -> None:
        batch, self._batch, self._batch_size = self._batch, [], 0
        if self._writer is None:
            return
        for channel, log_time, data in batch:
            if channel.file_id is None:
                schema = json.dumps(channel.type.schema()).encode()
                schema_id = self._writer.register_schema(channel.type.topic, "jsonschema", schema)
                channel.file_id = self._writer.register_channel(channel.type.topic, "json", schema_id)
            self._writer.add_message(channel.file_id, log_time, data, log_time)

    @contextmanager
    def _errors_remembered(self) -> Iterator[None]:
        """Stop writing at the first failure of the file, and keep it for `close`."""
        try:
            yield
        except OSError as error:
            self._error = error
            self._writer = None
            try:
                if self._stream is not None:
                    self._stream.close()
            except OSError:
                pass  # the same failure again, as its buffer is written out


@contextmanager
def _signals_held_back() -> Iterator[None]:
    """Let SIGINT, SIGTERM, SIGHUP and SIGQUIT wait until the block is done; Python runs handlers in the main thread only."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _held_back(signal.SIGINT), _held_back(signal.SIGTERM), _held_back(signal.SIGHUP), _held_back(signal.SIGQUIT):
        yield


@contextmanager
def _held_back(number: signal.Signals) -> Iterator[None]:
    handler = signal.getsignal(number)
    if not callable(handler):  # left to the operating system
        yield
        return
    caught: list[FrameType | None] = []
    signal.signal(number, lambda _, frame: caught.append(frame))
    try:
        yield
    finally:
        signal.signal(number, handler)
        for frame in caught:  # where one raises, the rest are lost in what it raises
            handler(number, frame)


def _header_text(header: Mapping[str, Any]) -> str:
    try:
        return json.dumps(dict(header), allow_nan=False, default=_plain)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"not for JSON: {error}", field=HEADER, given=repr(header)[:80]) from error


def _metadata_text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _plain(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} is neither a number, a text, an array nor a mapping")
