"""Recording: what was recorded, as arrays by topic and field; from memory or from an MCAP file, whole or truncated."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.exceptions import InvalidMagic
from mcap.reader import NonSeekingReader
from numpy.typing import NDArray

from doorman.exceptions import RecordingError
from doorman.recording.messages import MessageType, Row

HEADER = "header"
"""Topic whose only message is the header."""


class _UnknownNameError(RecordingError, KeyError):
    """A topic or field that the recording does not have; a KeyError too, as a mapping must raise."""


class Topic(Mapping[str, NDArray[Any]]):
    """Messages of one topic: arrays by field, with one row per message.

    Args:
        name: Name of the topic.
        time: Shape (m,) [s].
        columns: Arrays of shape (m, …) by field.
    """

    def __init__(self, name: str, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> None:
        self.name = name
        self.time = time
        self._columns = dict(columns)

    def __getitem__(self, field: str) -> NDArray[Any]:
        try:
            return self._columns[field]
        except KeyError:
            raise _UnknownNameError(
                f"topic '{self.name}' has no such field", field="field", given=field, allowed=", ".join(self)
            ) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"Topic({self.name!r}, {len(self.time)} messages of {', '.join(self)})"


class Recording(Mapping[str, Topic]):
    """Topics by name: `recording["truth"]["door_angle"]` is an array of shape (m,), `recording["truth"].time` its times.

    All arrays are read-only. A topic without messages is not there.

    Args:
        topics: The topics.
        header: What was run, as given to the recorder.
        complete: False if the file was cut off, or could not be written to its end.
    """

    def __init__(self, topics: Mapping[str, Topic], header: Mapping[str, Any], complete: bool = True) -> None:
        self._topics = dict(topics)
        self.header = dict(header)
        self.complete = complete
        self.summary: dict[str, Any] | None = None
        """Figures of the run, once somebody has computed them."""

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """Read an MCAP file that `Recorder` wrote.

        A file that was cut off, as by a crash, is read up to its last whole chunk; `complete` is then False.

        Args:
            path: The file.

        Returns:
            The recording.

        Raises:
            RecordingError: if the file cannot be read, is no MCAP, or holds no header of doorman's.
        """
        path = Path(path)
        try:
            with path.open("rb") as stream:
                return _read(stream, path)
        except OSError as error:
            raise RecordingError(f"cannot be read: {error.strerror}", file=path) from error

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics, in the order of their first messages."""
        return tuple(self._topics)

    def __getitem__(self, topic: str) -> Topic:
        try:
            return self._topics[topic]
        except KeyError:
            raise _UnknownNameError(
                "the recording has no such topic", field="topic", given=topic, allowed=", ".join(self) or "none"
            ) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._topics)

    def __len__(self) -> int:
        return len(self._topics)

    def __repr__(self) -> str:
        return f"Recording({', '.join(f'{name}: {len(topic.time)}' for name, topic in self.items())})"


def _read(stream: IO[bytes], path: Path) -> Recording:
    types: dict[str, MessageType] = {}
    rows: dict[str, list[Row]] = {}
    header: dict[str, Any] | None = None
    complete = False
    reader = NonSeekingReader(stream, validate_crcs=True)  # needs no index, which a truncated file lacks
    try:
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            topic = channel.topic
            if topic == HEADER:
                header = json.loads(message.data)
            elif header is None:
                break
            else:
                if topic not in types:
                    types[topic] = MessageType.from_schema(topic, json.loads(schema.data) if schema else {})
                rows.setdefault(topic, []).append(types[topic].decode(message.data))
        else:
            complete = True
    except (RecordingError, OSError):
        raise
    except Exception as error:  # cut off inside a record: parsers raise whatever they stumble over
        if isinstance(error, InvalidMagic) and header is None:
            raise RecordingError("not an MCAP file", file=path) from error
    if header is None:
        raise RecordingError("holds no header of a doorman recording", file=path)
    topics = {name: Topic(name, *types[name].columns(entries)) for name, entries in rows.items()}
    return Recording(topics, header, complete)
