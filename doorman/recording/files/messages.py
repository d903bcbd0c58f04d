"""Type of a topic's messages: fixed by the first message, checked against every later one, written as CDR with a schema.

Floats keep all their digits, and NaN and infinities are what they are. An array of 32-bit floats is stored as such: a plan's
states, of which a viewer shows curves, take half the room.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import sealed
from doorman.bounds import LAST_TIME
from doorman.exceptions import RecordingError, shown
from doorman.recording.files.cdr import BEGIN, STORED, TIME, Field, Kind, Layout, read_fields

Value: TypeAlias = float | int | bool | str | NDArray[Any] | Sequence[Any]
Columns: TypeAlias = tuple[NDArray[np.float64], dict[str, NDArray[Any]]]
"""Times, shape (m,) [s], and for every field an array of m rows."""

_TIME = struct.Struct("<d")
_DTYPES: dict[Kind, type] = {
    "number": np.float64, "single": np.float32, "integer": np.int64, "boolean": np.bool_, "string": np.str_,
}  # fmt: skip
_EXACT: dict[Kind, type] = {"number": float, "integer": int, "boolean": bool}
"""Types of single values that are stored as they are."""
_KINDS: dict[str, Kind] = {"f": "number", "i": "integer", "u": "integer", "b": "boolean", "U": "string"}
_ACCEPTED: dict[Kind, str] = {"number": "fiu", "single": "f", "integer": "iu", "boolean": "b", "string": "U"}
"""Kinds of numpy that a field takes."""
_WORDS: dict[Kind, str] = {
    "number": "a number", "single": "a number of 32 bits", "integer": "a whole number", "boolean": "true or false",
    "string": "a text",
}  # fmt: skip


class MessageType:
    """Fields of one topic's messages."""

    def __init__(self, topic: str, fields: Sequence[Field]) -> None:
        self.topic = topic
        self.fields = tuple(fields)
        self._layout = layout = Layout(fields)
        self.size = len(BEGIN) + layout.dtype.itemsize
        """Of the fixed part of a message [bytes]."""
        self._row = np.zeros((), layout.dtype)  # every message fills it anew
        self._fixed = [
            (field.name, self._row[field.name], None if field.shape else _EXACT.get(field.kind), _converter(field))
            for field in layout.fixed
        ]
        self._texts = [(field.name, _converter(field)) for field in layout.texts]
        self._known: tuple[list[str], bytes] = [], b""  # texts of the message before, as they are stored
        self._read_tail = lru_cache(maxsize=4096)(layout.read_tail)  # most are like many others

    @classmethod
    def of(cls, topic: str, message: Mapping[str, Value]) -> MessageType:
        """The type of a topic whose first message is given."""
        return cls(topic, [_field(topic, name, value) for name, value in message.items()])

    @classmethod
    def from_schema(cls, topic: str, schema: bytes) -> MessageType:
        """The type that `schema` describes, as `MessageType.schema` writes it."""
        try:
            return cls(topic, read_fields(schema.decode()))
        except (ValueError, TypeError, RecursionError) as error:
            raise RecordingError("not a schema of doorman's", field=topic, given=shown(schema[:80])) from error

    def schema(self) -> str:
        """The schema of a message (ros2msg)."""
        return self._layout.schema(self.fields)

    def encode(self, time: float, message: Mapping[str, Value]) -> bytes:
        """A message as CDR."""
        name, tail = "", b""
        if len(message) != len(self.fields):
            raise self._other_fields(message)
        try:
            self._row[TIME] = time
            for name, place, exact, convert in self._fixed:
                value: Any = message[name]
                place[...] = value if value.__class__ is exact else convert(value)
            if self._texts:
                texts: list[str] = []
                for name, convert in self._texts:
                    value = message[name]
                    texts += (value,) if value.__class__ is str else convert(value).ravel().tolist()
                if texts != self._known[0]:  # most are those of the message before
                    self._known = texts, self._layout.tail(texts)
                tail = self._known[1]
        except KeyError:
            raise self._other_fields(message) from None
        except (TypeError, ValueError, OverflowError):
            raise self._other_value(name, message[name]) from None
        return BEGIN + self._row.tobytes() + tail

    def fits(self, message: bytes) -> bool:
        """Whether it is a whole message of this type, with a time."""
        if len(message) < self.size or not 0.0 <= time_of(message) <= LAST_TIME:
            return False
        try:
            self._read_tail(message[self.size :])
        except ValueError:
            return False
        return True

    def columns(self, messages: Sequence[bytes]) -> Columns:
        """Take messages apart that fit."""
        rows = np.frombuffer(b"".join([one[len(BEGIN) : self.size] for one in messages]), self._layout.dtype)
        texts = [self._read_tail(one[self.size :]) for one in messages] if self._texts else []
        columns, place = {}, 0
        for field in self._layout.texts:
            values = [row[place : place + field.entries] for row in texts]
            columns[field.name] = sealed(np.array(values, dtype=np.str_).reshape(len(messages), *field.shape))
            place += field.entries
        for field in self._layout.fixed:  # single precision becomes double
            dtype = np.float64 if field.kind == "single" else np.dtype(STORED[field.kind]).newbyteorder("=")
            columns[field.name] = sealed(np.array(rows[field.name], dtype=dtype, order="C"))
        return sealed(np.array(rows[TIME], dtype=np.float64)), {
            field.name: columns[field.name] for field in self.fields
        }

    def _other_value(self, name: str, value: object) -> RecordingError:
        """The error for a value of another type or shape than the field has."""
        field = next(field for field in self.fields if field.name == name)
        word = _WORDS[field.kind]
        return RecordingError(
            "another type or shape than in the topic's first message", field=f"{self.topic}.{name}", given=shown(value),
            allowed=f"an array of shape {field.shape}, each {word}" if field.shape else word,
        )  # fmt: skip

    def _other_fields(self, message: Mapping[str, Value]) -> RecordingError:
        names = ", ".join(field.name for field in self.fields)
        return RecordingError(
            "other fields than in the topic's first message", field=self.topic, given=", ".join(message), allowed=names
        )


def time_of(message: bytes) -> float:
    """Time of an encoded message [s]."""
    return float(_TIME.unpack_from(message, len(BEGIN))[0])


def joined(blocks: Sequence[Columns]) -> Columns:
    """Columns of several blocks of rows of one topic, one after the other."""
    if len(blocks) == 1:
        return blocks[0]
    time = np.concatenate([times for times, _ in blocks])
    fields = {name: np.concatenate([columns[name] for _, columns in blocks]) for name in blocks[0][1]}
    return sealed(time), {name: sealed(values) for name, values in fields.items()}


def _field(topic: str, name: str, value: Value) -> Field:
    where = f"{topic}.{name}"
    if name == TIME:
        raise RecordingError("the name is taken by the message's own time", field=where, allowed="another name")
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        array = np.empty((), dtype=object)
    kind = _KINDS.get(array.dtype.kind)
    if kind is None or not np.can_cast(array.dtype, _DTYPES[kind]) or (kind == "string" and not _all_texts(value)):
        raise RecordingError(
            "cannot be recorded", field=where, given=shown(value), allowed="numbers, texts, and arrays of them"
        )
    if array.dtype == np.float32 and array.shape:
        kind = "single"
    return Field(name, kind, array.shape)


def _all_texts(value: Value) -> bool:
    """Whether numpy has not turned numbers into texts."""
    return all(isinstance(entry, str) for entry in np.asarray(value, dtype=object).flat)


def _converter(field: Field) -> Callable[[Any], NDArray[Any]]:
    """A function that converts a value of a field to what is stored; it raises TypeError, ValueError or OverflowError."""
    dtype, shape, accepted = np.dtype(_DTYPES[field.kind]), field.shape, _ACCEPTED[field.kind]
    casting: Any = "same_kind" if field.kind == "single" else "safe"

    def convert(value: Any) -> NDArray[Any]:
        given = np.asarray(value)
        if given.shape != shape or given.dtype.kind not in accepted:
            raise TypeError
        return given if given.dtype is dtype else given.astype(dtype, casting=casting, copy=False)

    return convert
