"""Type of a topic's messages: fixed by the first message, checked against every later one, written as JSON with a schema.

Floats keep all their digits. JSON has no NaN and no infinities: they are written as the strings "NaN", "Infinity" and
"-Infinity", and read back as the floats they were. Long arrays of floats, such as a plan's states, are written as the
base64 text of their bytes, as their schema says: digits would take seven times as long, too long for a control loop.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import orjson
from numpy.typing import NDArray

from doorman.exceptions import RecordingError

Value: TypeAlias = float | int | bool | str | NDArray[Any] | Sequence[Any]
Kind = Literal["number", "integer", "boolean", "string"]
Row: TypeAlias = tuple[Any, ...]
Columns: TypeAlias = tuple[NDArray[np.float64], dict[str, NDArray[Any]]]
"""Times, shape (m,) [s], and for every field an array of m rows."""

HEADER = "header"
"""Topic whose only message is the header."""

TIME = "time"
"""Every message's first entry, in seconds; no field may have this name."""

_LONG = 64
"""Arrays of more floats than this are written as bytes."""
_BYTES = np.dtype("<f8")
_DTYPES: dict[Kind, type] = {"number": np.float64, "integer": np.int64, "boolean": np.bool_, "string": np.str_}
_KINDS: dict[str, Kind] = {"f": "number", "i": "integer", "u": "integer", "b": "boolean", "U": "string"}
_WORDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "string": "a text"}


class Field(NamedTuple):
    """One named value of a message."""

    name: str
    kind: Kind
    shape: tuple[int, ...]
    """() for a single value."""

    @property
    def packed(self) -> bool:
        """Whether the field is written as the base64 text of its bytes."""
        return self.kind == "number" and math.prod(self.shape) > _LONG

    def schema(self) -> dict[str, Any]:
        """The JSON schema of the field."""
        if self.packed:
            what = "row-major little-endian 64-bit floats"
            return {"type": "string", "contentEncoding": "base64", "shape": self.shape, "description": what}
        schema: dict[str, Any] = {"type": self.kind}
        for size in reversed(self.shape):
            schema = {"type": "array", "items": schema, "minItems": size, "maxItems": size}
        return schema

    @classmethod
    def from_schema(cls, name: str, schema: Mapping[str, Any]) -> Field:
        """The field that `schema` describes; KeyError, TypeError or ValueError if it is not one of ours."""
        if "contentEncoding" in schema:
            return cls(name, "number", tuple(schema["shape"]))
        shape: list[int] = []
        while schema["type"] == "array":
            shape.append(int(schema["minItems"]))
            schema = schema["items"]
        if schema["type"] not in _DTYPES:
            raise ValueError(schema["type"])
        return cls(name, schema["type"], tuple(shape))

    def plain(self, value: Any) -> Any:
        """A copied value as JSON can hold it, but for floats that are not finite."""
        if self.packed:
            return base64.b64encode(value.astype(_BYTES, copy=False).tobytes()).decode("ascii")
        return value.tolist() if self.shape else value

    def read(self, value: Any) -> Any:
        """What `plain` made of a value, as something that numpy turns into the value."""
        if not self.packed:
            return value
        return np.frombuffer(base64.b64decode(value, validate=True), _BYTES).reshape(self.shape)


class MessageType:
    """Fields of one topic's messages.

    Args:
        topic: Name of the topic, for errors.
        fields: The fields, in the order in which they are written.
    """

    def __init__(self, topic: str, fields: Sequence[Field]) -> None:
        self.topic = topic
        self.fields = tuple(fields)
        self._converters = [(field.name, _converter(field)) for field in self.fields]
        self._plain = [(field.name, field.plain if field.shape else None) for field in self.fields]

    @classmethod
    def of(cls, topic: str, message: Mapping[str, Value]) -> MessageType:
        """The type of a topic whose first message is given.

        Raises:
            RecordingError: if a value is neither a number, a text, nor an array of one of these.
        """
        return cls(topic, [_field(topic, name, value) for name, value in message.items()])

    @classmethod
    def from_schema(cls, topic: str, schema: Mapping[str, Any]) -> MessageType:
        """The type that `schema` describes, as `MessageType.schema` writes it.

        Raises:
            RecordingError: if the schema was not written by doorman.
        """
        try:
            entries = schema["properties"].items()
            fields = [Field.from_schema(name, entry) for name, entry in entries if name != TIME]
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise RecordingError("not a schema of doorman's", field=topic, given=str(schema)[:80]) from error
        return cls(topic, fields)

    def schema(self) -> dict[str, Any]:
        """The JSON schema of a message."""
        properties: dict[str, Any] = {TIME: {"type": "number", "description": "[s]"}}
        properties |= {field.name: field.schema() for field in self.fields}
        return {
            "type": "object",
            "description": 'Numbers that are not finite are the strings "NaN", "Infinity" and "-Infinity".',
            "properties": properties,
            "required": list(properties),
        }

    def row(self, time: float, message: Mapping[str, Value]) -> Row:
        """Copy a message into a row [time, value of every field].

        Raises:
            RecordingError: if the message has other fields than the topic's first one, or a field has another type or shape.
        """
        row: list[Any] = [time]
        name = ""
        try:
            for name, convert in self._converters:
                row.append(convert(message[name]))
        except KeyError:
            raise self._other_fields(message) from None
        except (TypeError, ValueError, OverflowError):
            field = next(field for field in self.fields if field.name == name)
            raise RecordingError(
                "another type or shape than in the topic's first message",
                field=f"{self.topic}.{name}", given=repr(message[name])[:80], allowed=_describe(field),
            ) from None  # fmt: skip
        if len(message) != len(self._converters):
            raise self._other_fields(message)
        return tuple(row)

    def encode(self, row: Row) -> bytes:
        """A row as JSON."""
        plain: dict[str, Any] = {TIME: row[0]}
        for (name, to_plain), value in zip(self._plain, row[1:], strict=True):
            plain[name] = value if to_plain is None else to_plain(value)
        data = orjson.dumps(plain)
        if b"null" in data:  # it writes numbers that are not finite so
            data = orjson.dumps(_with_words(plain))
        return data

    def decode(self, data: bytes) -> Row:
        """The row that `encode` turned into `data`.

        Raises:
            ValueError: if the data is no JSON.
            KeyError: if a field is missing.
        """
        message = json.loads(data)
        return (message[TIME], *(field.read(message[field.name]) for field in self.fields))

    def columns(self, rows: Sequence[Row]) -> Columns:
        """Stack rows, be they copied or decoded.

        Args:
            rows: m ≥ 1 rows of this type.

        Returns:
            Times, shape (m,) [s], and for every field an array of shape (m, *shape); all of them read-only.
        """
        time, *values = zip(*rows, strict=True)
        columns = {
            field.name: _frozen(np.array(column, dtype=_DTYPES[field.kind]).reshape(len(rows), *field.shape))
            for field, column in zip(self.fields, values, strict=True)
        }
        return _frozen(np.array(time, dtype=np.float64)), columns

    def _other_fields(self, message: Mapping[str, Value]) -> RecordingError:
        names = ", ".join(field.name for field in self.fields)
        return RecordingError(
            "other fields than in the topic's first message", field=self.topic, given=", ".join(message), allowed=names
        )


def joined(blocks: Sequence[Columns]) -> Columns:
    """Columns of several blocks of rows of one topic, one after the other.

    Args:
        blocks: At least one, all of one type.

    Returns:
        Times and fields, read-only.
    """
    if len(blocks) == 1:
        return blocks[0]
    time = np.concatenate([times for times, _ in blocks])
    fields = {name: np.concatenate([columns[name] for _, columns in blocks]) for name in blocks[0][1]}
    return _frozen(time), {name: _frozen(values) for name, values in fields.items()}


def header_schema(value: Any) -> dict[str, Any]:
    """The JSON schema of a recording's header, or of a part of it.

    Viewers iterate over `properties` and know no other types than these: what is null, or an array of other things than plain
    values, is left out, which a schema may do.

    Args:
        value: Of JSON.

    Returns:
        The schema; empty for what is left out.
    """
    if isinstance(value, Mapping):
        entries = {name: header_schema(entry) for name, entry in value.items()}
        return {"type": "object", "properties": {name: schema for name, schema in entries.items() if schema}}
    if isinstance(value, list):
        kinds = [header_schema(entry) for entry in value]
        plain = bool(kinds) and all(kind == kinds[0] and kind.get("type") in _DTYPES for kind in kinds)
        return {"type": "array", "items": kinds[0]} if plain else {}
    for type_, name in ((bool, "boolean"), (str, "string"), ((int, float), "number")):
        if isinstance(value, type_):
            return {"type": name}
    return {}


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array


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
            "cannot be recorded", field=where, given=repr(value)[:80], allowed="numbers, texts, and arrays of them"
        )
    return Field(name, kind, array.shape)


def _all_texts(value: Value) -> bool:
    """Whether numpy has not turned numbers into texts."""
    return all(isinstance(entry, str) for entry in np.asarray(value, dtype=object).flat)


def _describe(field: Field) -> str:
    return f"an array of shape {field.shape}, each {_WORDS[field.kind]}" if field.shape else _WORDS[field.kind]


def _with_words(value: Any) -> Any:
    """The same with NaN and infinities as strings."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, dict):
        return {key: _with_words(entry) for key, entry in value.items()}
    return [_with_words(entry) for entry in value] if isinstance(value, list) else value


def _converter(field: Field) -> Callable[[Any], Any]:
    """A function that copies a value of this field, or raises TypeError, ValueError or OverflowError."""
    return _array_converter(field) if field.shape else _SCALAR_CONVERTERS[field.kind]


def _array_converter(field: Field) -> Callable[[Any], Any]:
    dtype, shape = _DTYPES[field.kind], field.shape
    accepted = {"number": "fiu", "integer": "iu", "boolean": "b", "string": "U"}[field.kind]

    def convert(value: Any) -> NDArray[Any]:
        given = np.asarray(value)
        if given.shape != shape or given.dtype.kind not in accepted:
            raise TypeError
        return given.astype(dtype, casting="safe")  # always a copy

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
