"""Type of a topic's messages: fixed by the first message, checked against every later one, written as CDR with a schema.

Floats keep all their digits, and NaN and infinities are what they are. An array of 32-bit floats is stored as such: a plan's
states, of which a viewer shows curves, take half the room.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import sealed
from doorman.exceptions import RecordingError, shown
from doorman.recording.files.cdr import TIME, Field, Kind, Layout, native, read_fields

Value: TypeAlias = float | int | bool | str | NDArray[Any] | Sequence[Any]
Columns: TypeAlias = tuple[NDArray[np.float64], dict[str, NDArray[Any]]]
"""Times, shape (m,) [s], and for every field an array of m rows."""

HEADER = "header"
"""Topic whose only message is the header."""

_DTYPES: dict[Kind, type] = {
    "number": np.float64, "single": np.float32, "integer": np.int64, "boolean": np.bool_, "string": np.str_,
}  # fmt: skip
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
        self.layout = Layout(fields)

    @classmethod
    def of(cls, topic: str, message: Mapping[str, Value]) -> MessageType:
        """The type of a topic whose first message is given."""
        return cls(topic, [_field(topic, name, value) for name, value in message.items()])

    @classmethod
    def from_schema(cls, topic: str, schema: str) -> MessageType:
        """The type that `schema` describes, as `MessageType.schema` writes it."""
        try:
            found = cls(topic, read_fields(schema))
            found.layout.dtype()  # two fields of one name have none
        except (ValueError, TypeError, RecursionError) as error:
            raise RecordingError("not a schema of doorman's", field=topic, given=schema[:80]) from error
        return found

    def schema(self) -> str:
        """The schema of a message (ros2msg)."""
        return self.layout.schema(self.fields)

    def columns(self, rows: NDArray[Any], tails: Sequence[bytes] = ()) -> Columns:
        """Take messages apart."""
        texts = self._texts(tails)
        columns = {
            field.name: sealed(texts[field.name] if field.kind == "string" else native(rows, field))
            for field in self.fields
        }
        return sealed(np.array(rows[TIME], dtype=np.float64)), columns

    def _texts(self, tails: Sequence[bytes]) -> dict[str, NDArray[np.str_]]:
        if not self.layout.texts:
            return {}
        read = {tail: self.layout.read_tail(tail) for tail in set(tails)}  # most are like many others
        rows, found, place = [read[tail] for tail in tails], {}, 0
        for field in self.layout.texts:
            values = [row[place : place + field.entries] for row in rows]
            found[field.name] = np.array(values, dtype=np.str_).reshape(len(rows), *field.shape)
            place += field.entries
        return found

    def other_value(self, name: str, value: object) -> RecordingError:
        """The error for a value of another type or shape than the field has."""
        field = next(field for field in self.fields if field.name == name)
        return RecordingError(
            "another type or shape than in the topic's first message",
            field=f"{self.topic}.{name}", given=shown(value), allowed=_describe(field),
        )  # fmt: skip

    def other_fields(self, message: Mapping[str, Value]) -> RecordingError:
        names = ", ".join(field.name for field in self.fields)
        return RecordingError(
            "other fields than in the topic's first message", field=self.topic, given=", ".join(message), allowed=names
        )


def converter(field: Field) -> Callable[[Any], Any]:
    """A function that converts a value of a field to what is stored; it raises TypeError, ValueError or OverflowError."""
    return _array_converter(field) if field.shape else _SCALAR_CONVERTERS[field.kind]


def joined(blocks: Sequence[Columns]) -> Columns:
    """Columns of several blocks of rows of one topic, one after the other."""
    if len(blocks) == 1:
        return blocks[0]
    time = np.concatenate([times for times, _ in blocks])
    fields = {name: np.concatenate([columns[name] for _, columns in blocks]) for name in blocks[0][1]}
    return sealed(time), {name: sealed(values) for name, values in fields.items()}


def header_schema(value: Any) -> dict[str, Any]:
    """The JSON schema of a recording's header, or of a part of it."""
    # Viewers iterate over `properties` and know no other types than these: what is null, or an array of other things than plain
    # values, is left out, which a schema may do.
    if isinstance(value, Mapping):
        entries = {name: header_schema(entry) for name, entry in value.items()}
        return {"type": "object", "properties": {name: schema for name, schema in entries.items() if schema}}
    if isinstance(value, list):
        kinds = [header_schema(entry) for entry in value]
        plain = bool(kinds) and all(kind == kinds[0] and kind.get("type") in _PLAIN for kind in kinds)
        return {"type": "array", "items": kinds[0]} if plain else {}
    for type_, name in ((bool, "boolean"), (str, "string"), ((int, float), "number")):
        if isinstance(value, type_):
            return {"type": name}
    return {}


_PLAIN = ("boolean", "string", "number")


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


def _describe(field: Field) -> str:
    return f"an array of shape {field.shape}, each {_WORDS[field.kind]}" if field.shape else _WORDS[field.kind]


def _array_converter(field: Field) -> Callable[[Any], Any]:
    dtype, shape, accepted = _DTYPES[field.kind], field.shape, _ACCEPTED[field.kind]
    casting: Any = "same_kind" if field.kind == "single" else "safe"

    def convert(value: Any) -> NDArray[Any]:
        given = np.asarray(value)
        if given.shape != shape or given.dtype.kind not in accepted:
            raise TypeError
        return given.astype(dtype, casting=casting, copy=False)

    return convert


def _number(value: Any) -> float:
    if isinstance(value, float):
        return float(value)
    if isinstance(value, (bool, np.bool_, str)) or np.ndim(value):
        raise TypeError
    return float(value)


def _integer(value: Any) -> int:
    if isinstance(value, np.ndarray):
        value = value.item()
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise TypeError
    if not -(2**63) <= value < 2**63:
        raise OverflowError
    return int(value)


def _boolean(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        value = value.item()
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError
    return bool(value)


def _string(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    return str(value)


_SCALAR_CONVERTERS: dict[Kind, Callable[[Any], Any]] = {
    "number": _number,
    "integer": _integer,
    "boolean": _boolean,
    "string": _string,
}


def header_json(header: Mapping[str, Any]) -> str:
    """The header as JSON; arrays and paths become lists and texts."""
    try:
        return json.dumps(dict(header), allow_nan=False, default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise RecordingError(f"cannot be written as JSON: {error}", field=HEADER, given=shown(header)) from error


def _plain(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} is neither a number, a text, an array nor a mapping")


def header_value(text: str) -> Any:
    """Value of the header from the text in its metadata record."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def header_text(value: Any) -> str:
    """Text of a value of the header: the words themselves where they are no JSON, so that they read well."""
    return value if isinstance(value, str) and header_value(value) is value else json.dumps(value)
