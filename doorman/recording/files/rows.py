"""Messages of one topic that wait to be written: rows of one array, framed as MCAP has them in a chunk."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from doorman.recording.files.cdr import HEADER, STORED, TIME, Field
from doorman.recording.files.messages import Columns, MessageType, Value, converter

_RECORD = struct.Struct("<BQHIQQ")
"""What stands before a message: opcode, length, topic, sequence and times."""
_UNCOUNTED = 9
"""Bytes of a record that its length does not count."""
_FRAME = {"length": ("<u8", 1), "channel": ("<u2", 9), "log": ("<u8", 15), "publish": ("<u8", 23)}
"""Type and place of what is filled in at the end."""
_MOST_BYTES = 64_000
"""Most bytes of one topic that wait."""
_CODES = {"number": "d", "integer": "q", "boolean": "?"}
"""Codes of single values for `struct`."""
_EXACT = {"number": float, "integer": int, "boolean": bool}
"""Types of single values that are stored as they are."""


class Framed(NamedTuple):
    """Messages as they stand in a chunk."""

    data: bytes
    times: NDArray[np.uint64]  # shape (m,) [ns]
    places: NDArray[np.uint64]  # where each record begins in the data, shape (m,) [bytes]

    @classmethod
    def of(cls, channel: int, message: bytes) -> Framed:
        """One message of time 0, framed."""
        frame = _RECORD.pack(Opcode.MESSAGE, _RECORD.size - _UNCOUNTED + len(message), channel, 0, 0, 0)
        return cls(frame + message, np.zeros(1, dtype=np.uint64), np.zeros(1, dtype=np.uint64))


class _Group:
    def __init__(self, fields: list[Field]) -> None:
        self.kind = fields[0].kind
        self.dtype = np.dtype(STORED[self.kind])
        self.exact = _EXACT.get(self.kind)
        single = [field for field in fields if not field.shape]
        self.single = [(field.name, converter(field)) for field in single if field.name != TIME]
        self.names = [name for name, _ in self.single]
        self.types = [None if self.kind == "integer" else self.exact] * len(self.names)  # integers may be too large
        self.arrays = [
            (field.name, field.shape, converter(field), self._packer(field.entries)) for field in fields if field.shape
        ]
        self.pack = self._packer(len(single))

    def _packer(self, count: int) -> Callable[..., bytes]:
        """What packs so many values of the kind, of the exact type that `struct` takes as it is."""
        return struct.Struct(f"<{count}{_CODES.get(self.kind, 'f')}").pack


class Rows:
    """Gathers messages of one type."""

    def __init__(self, type_: MessageType) -> None:
        self.type = type_
        layout = type_.layout
        self._groups = [
            _Group(fields) for kind in STORED if (fields := [field for field in layout.stored if field.kind == kind])
        ]
        self._texts = [(field.name, field.shape, converter(field)) for field in layout.texts]
        self._known_tails: dict[tuple[str, ...], bytes] = {}
        self._fields = len(type_.fields)
        self._size = layout.dtype(_RECORD.size).itemsize
        self._begin = _RECORD.pack(Opcode.MESSAGE, self._size - _UNCOUNTED, 0, 0, 0, 0) + HEADER
        self._most = max(_MOST_BYTES // self._size, 1)
        self._records: list[tuple[float, bytes]] = []  # time and record of every message, whole once it is here

    def __len__(self) -> int:
        return len(self._records)

    @property
    def full(self) -> bool:
        """Whether it is time to write them."""
        return len(self._records) >= self._most

    def add(self, time: float, message: Mapping[str, Value]) -> None:
        parts, name, first = [self._begin], "", [time]
        try:
            for group in self._groups:
                exact, dtype = group.exact, group.dtype
                single: list[Any] = [message[name] for name in group.names]
                if list(map(type, single)) != group.types:
                    for place, (name, convert) in enumerate(group.single):
                        single[place] = convert(single[place])
                parts.append(group.pack(*first, *single))
                first = []
                for name, shape, convert, several in group.arrays:
                    value: Any = message[name]
                    if value.__class__ is np.ndarray and value.dtype is dtype and value.shape == shape:
                        parts.append(value.tobytes())
                    elif value.__class__ is list and set(map(type, value)) == {exact} and shape == (len(value),):
                        parts.append(several(*value))
                    else:
                        parts.append(convert(value).tobytes())
            if self._texts:
                texts: list[str] = []
                for name, shape, convert in self._texts:
                    value = convert(message[name])
                    texts += value.ravel().tolist() if shape else (value,)
                parts.append(self._tail(tuple(texts)))
        except KeyError:
            raise self.type.other_fields(message) from None
        except (TypeError, ValueError, OverflowError, struct.error):
            raise self.type.other_value(name, message[name]) from None
        if len(message) != self._fields:
            raise self.type.other_fields(message)
        self._records.append((time, b"".join(parts)))

    def framed(self, channel: int) -> Framed:
        """The messages as records of MCAP; at least one."""
        seconds, records = zip(*self._records, strict=True)
        times = np.round(1e9 * np.array(seconds)).astype(np.uint64)
        sizes = np.array([len(record) for record in records], dtype=np.uint64)
        fixed = np.frombuffer(bytearray(self._fixed(records)), self._frame_type())
        fixed["channel"], fixed["length"] = channel, sizes - np.uint64(_UNCOUNTED)
        fixed["log"] = fixed["publish"] = times
        data, size = fixed.tobytes(), self._size
        if self._texts:
            parts = zip(range(0, len(data), size), records, strict=True)
            data = b"".join(part for at, record in parts for part in (data[at : at + size], record[size:]))
        return Framed(data, times, np.cumsum(sizes) - sizes)

    def columns(self) -> Columns:
        """The messages taken apart; at least one."""
        records = [record for _, record in self._records]
        tails = [record[self._size :] for record in records] if self._texts else []
        rows = np.frombuffer(self._fixed(records), self.type.layout.dtype(_RECORD.size))
        return self.type.columns(rows, tails)

    def clear(self) -> None:
        self._records = []

    def _fixed(self, records: Sequence[bytes]) -> bytes:
        """The part of all messages that is as long in each."""
        return b"".join([record[: self._size] for record in records] if self._texts else records)

    def _frame_type(self) -> np.dtype[Any]:
        formats, places = zip(*_FRAME.values(), strict=True)
        return np.dtype(
            {"names": list(_FRAME), "formats": list(formats), "offsets": list(places), "itemsize": self._size}
        )

    def _tail(self, texts: tuple[str, ...]) -> bytes:
        """Texts as they are stored; most are those of the message before."""
        tail = self._known_tails.get(texts)
        if tail is None:
            tail = self.type.layout.tail(texts)
            self._known_tails = {texts: tail}
        return tail
