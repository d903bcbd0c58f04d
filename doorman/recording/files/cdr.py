"""Layout of a topic's messages as ROS 2 writes them (CDR), and the schema that says so (ros2msg): what viewers read.

Numbers and flags of all arrays stand at fixed places, the widest first, so that many messages are one array of rows. Texts
follow, as long as they are.
"""

from __future__ import annotations

import json
import math
import re
import struct
from collections.abc import Iterable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from doorman.bounds import LARGEST_CHUNK

Kind = Literal["number", "single", "integer", "boolean", "string"]

BEGIN = b"\x00\x01\x00\x00"
"""First bytes of every message: little-endian CDR."""

TIME = "time"
"""Every message's first entry, in seconds; no field may have this name."""

STORED: dict[Kind, str] = {"number": "<f8", "integer": "<i8", "single": "<f4", "boolean": "?"}
"""How a value is stored, in the order in which they stand; texts are not of fixed length."""
_ROS: dict[Kind, str] = {
    "number": "float64", "single": "float32", "integer": "int64", "boolean": "bool", "string": "string",
}  # fmt: skip
_TYPES = "# doorman: "
"""Begins the schema's line with names, kinds and shapes as JSON."""
_LENGTH = struct.Struct("<I")


class Field(NamedTuple):
    name: str
    kind: Kind
    shape: tuple[int, ...]  # () for a single value

    @property
    def entries(self) -> int:
        """Number of values."""
        return math.prod(self.shape)


class Layout:
    def __init__(self, fields: Sequence[Field]) -> None:
        self.fixed = tuple(field for field in fields if field.kind != "string")
        self.texts = tuple(field for field in fields if field.kind == "string")
        time = Field(TIME, "number", ())
        order = {kind: place for place, kind in enumerate(STORED)}
        self.stored = sorted((time, *self.fixed), key=lambda field: (order[field.kind], bool(field.shape)))
        """Fields as stored: time first, then by kind, single values before arrays."""
        self.dtype = np.dtype([(field.name, STORED[field.kind], field.shape) for field in self.stored])
        """The fixed part of a message, behind its first bytes, as a row of an array."""

    def tail(self, texts: Iterable[str]) -> bytes:
        """What follows the fixed part."""
        place = self.dtype.itemsize
        parts = []
        for text in texts:
            data = text.encode("utf-8", "surrogatepass") + b"\x00"
            gap = -place % _LENGTH.size
            parts += [bytes(gap), _LENGTH.pack(len(data)), data]
            place += gap + _LENGTH.size + len(data)
        return b"".join(parts)

    def read_tail(self, tail: bytes) -> list[str]:
        """The texts behind the fixed part of a message, as `tail` writes them."""
        place, start = 0, self.dtype.itemsize
        texts = []
        for _ in range(sum(field.entries for field in self.texts)):
            place += -(start + place) % _LENGTH.size
            if place + _LENGTH.size > len(tail):
                raise ValueError("a text is missing")
            (length,) = _LENGTH.unpack_from(tail, place)
            place += _LENGTH.size
            data = tail[place : place + length]
            if len(data) != length or not data.endswith(b"\x00"):
                raise ValueError("a text is cut off")
            texts.append(data[:-1].decode("utf-8", "surrogatepass"))
            place += length
        if place != len(tail):
            raise ValueError("data after the last text")
        return texts

    def schema(self, fields: Sequence[Field]) -> str:
        """The schema, whose first line `read_fields` reads."""
        lines = [_TYPES + json.dumps([[field.name, field.kind, list(field.shape)] for field in fields])]
        taken: set[str] = set()
        for field in (*self.stored, *self.texts):
            if field.entries:  # ROS 2 has no arrays of nothing
                lines.append(_line(field, taken))
        return "\n".join(lines) + "\n"


def _line(field: Field, taken: set[str]) -> str:
    """The field as ROS 2 declares it, by a name that no other field of the message has."""
    name = plain = re.sub(r"_+", "_", re.sub(r"[^0-9A-Za-z]", "_", field.name)).strip("_") or "field"
    name = plain = plain if plain[0].isalpha() else f"field_{plain}"
    number = 1
    while name.lower() in taken:
        number += 1
        name = f"{plain}_{number}"
    taken.add(name.lower())
    size = f"[{field.entries}]" if field.shape else ""
    rows = f"  # {' x '.join(map(str, field.shape))}, row by row" if len(field.shape) > 1 else ""
    return f"{_ROS[field.kind]}{size} {name}{rows}"


def read_fields(schema: str) -> list[Field]:
    """The fields that a schema of `Layout.schema` describes."""
    first, _, _ = schema.partition("\n")
    if not first.startswith(_TYPES):
        raise ValueError("not a schema of doorman's")
    fields = []
    for name, kind, shape in json.loads(first.removeprefix(_TYPES)):
        if kind not in _ROS or not isinstance(name, str) or not all(type(size) is int and size >= 0 for size in shape):
            raise ValueError(kind)
        fields.append(Field(name, kind, tuple(shape)))
    if sum(field.entries for field in fields) > LARGEST_CHUNK:
        raise ValueError("no chunk holds such a message")
    return fields


def type_name(topic: str) -> str:
    """Name of a topic's type in ROS 2, such as `doorman/msg/Plan`."""
    words = re.findall(r"[0-9A-Za-z]+", topic)
    name = "".join(word[:1].upper() + word[1:] for word in words) or "Message"
    return f"doorman/msg/{name if name[0].isalpha() else f'T{name}'}"
