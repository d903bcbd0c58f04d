"""Messages of one topic that wait to be written: rows of one array, framed as MCAP has them in a chunk."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from doorman.recording.files.cdr import HEADER, STORED, TIME
from doorman.recording.files.messages import Columns, MessageType, Value, converter

_RECORD = struct.Struct("<BQHIQQ")
"""What stands before a message: opcode, length, topic, sequence and times."""
_UNCOUNTED = 9
"""Bytes of a record that its length does not count."""
_BEFORE = _RECORD.size + len(HEADER)
"""Bytes of a record before its values."""
_FRAME = {"length": ("<u8", 1), "log": ("<u8", 15), "publish": ("<u8", 23)}
"""Type and place of what is filled in at the end."""
_MOST_BYTES = 64_000
"""Most bytes of one topic that wait."""
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


class Rows:
    """Gathers messages of one type: a row of an array each, with a column for every field."""

    def __init__(self, type_: MessageType) -> None:
        self.type = type_
        layout = type_.layout
        row = layout.dtype(-len(HEADER))
        self._rows = np.zeros(max(_MOST_BYTES // row.itemsize, 1), row)
        self._times = self._rows[TIME]
        self._single = [
            (field.name, self._rows[field.name], _EXACT.get(field.kind), converter(field))
            for field in layout.fixed if not field.shape
        ]  # fmt: skip
        self._arrays = [
            (field.name, self._rows[field.name], np.dtype(STORED[field.kind]), field.shape, converter(field))
            for field in layout.fixed if field.shape
        ]  # fmt: skip
        self._texts = [(field.name, field.shape, converter(field)) for field in layout.texts]
        self._known: tuple[list[str], bytes] = [], b""  # texts of the message before, as they are stored
        self._fields = len(type_.fields)
        self._tails: list[bytes] = []  # one of every message, which is whole once it is here

    def __len__(self) -> int:
        return len(self._tails)

    def add(self, time: float, message: Mapping[str, Value]) -> bool:
        """Take a message; returns whether it is time to write them all."""
        row, name, tail = len(self._tails), "", b""
        if len(message) != self._fields:
            raise self.type.other_fields(message)
        try:
            self._times[row] = time
            for name, column, exact, convert in self._single:
                value: Any = message[name]
                column[row] = value if value.__class__ is exact else convert(value)
            for name, column, dtype, shape, convert in self._arrays:
                value = message[name]
                if not (value.__class__ is np.ndarray and value.dtype is dtype and value.shape == shape):
                    value = convert(value)
                column[row] = value
            if self._texts:
                texts: list[str] = []
                for name, shape, convert in self._texts:
                    value = convert(message[name])
                    texts += value.ravel().tolist() if shape else (value,)
                if texts != self._known[0]:  # most are those of the message before
                    self._known = texts, self.type.layout.tail(texts)
                tail = self._known[1]
        except KeyError:
            raise self.type.other_fields(message) from None
        except (TypeError, ValueError, OverflowError):
            raise self.type.other_value(name, message[name]) from None
        self._tails.append(tail)
        return row + 1 == len(self._rows)

    def framed(self, channel: int) -> Framed:
        """The messages as records of MCAP; at least one."""
        tails, size = self._tails, _BEFORE + self._rows.itemsize
        times = np.round(1e9 * self._times[: len(tails)]).astype(np.uint64)
        sizes = np.array([size + len(tail) for tail in tails], dtype=np.uint64)
        records = np.empty((len(tails), size), dtype=np.uint8)
        records[:, :_BEFORE] = np.frombuffer(_RECORD.pack(Opcode.MESSAGE, 0, channel, 0, 0, 0) + HEADER, np.uint8)
        records[:, _BEFORE:] = self._rows[: len(tails)].view(np.uint8).reshape(len(tails), -1)
        fixed = records.view(_frame_type(size))[:, 0]
        fixed["length"] = sizes - np.uint64(_UNCOUNTED)
        fixed["log"] = fixed["publish"] = times
        data = records.tobytes()
        if self._texts:
            parts = zip(range(0, len(data), size), tails, strict=True)
            data = b"".join(part for at, tail in parts for part in (data[at : at + size], tail))
        return Framed(data, times, np.cumsum(sizes) - sizes)

    def columns(self) -> Columns:
        """The messages taken apart; at least one."""
        return self.type.columns(self._rows[: len(self._tails)], self._tails)

    def clear(self) -> None:
        self._tails = []


def _frame_type(size: int) -> np.dtype[Any]:
    formats, places = zip(*_FRAME.values(), strict=True)
    return np.dtype({"names": list(_FRAME), "formats": list(formats), "offsets": list(places), "itemsize": size})
