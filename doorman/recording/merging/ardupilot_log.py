"""ArduPilot's binary DataFlash log: messages with their instances, and the gyroscope's rates.

Every message begins with two bytes and its kind; FMT messages say how long a kind is and what it holds. Behind damage, reading
goes on at the next message that another one follows.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.bounds import LARGEST_LOG, read_bytes
from doorman.exceptions import RecordingError
from doorman.recording.merging.flight_log import FlightLog, LogRows, flight_log, texts

_HEAD = b"\xa3\x95"
_FORMAT_KIND = 0x80
_TIME = "TimeUS"
_TYPES = {
    "a": "(32,)<i2", "b": "i1", "B": "u1", "g": "<f2", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "f": "<f4", "d": "<f8",
    "n": "S4", "N": "S16", "Z": "S64", "c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4", "L": "<i4", "M": "i1", "q": "<i8",
    "Q": "<u8",
}  # fmt: skip
"""By the letter of a format."""
_DIVISORS = dict.fromkeys("cCeE", 100) | {"L": 10_000_000}
_NAME = re.compile(rb"[A-Za-z0-9_]+")


@dataclass
class _Kind:
    """A kind of message."""

    name: str
    length: int  # of a message, its head included [bytes]
    columns: dict[str, str]  # letter by name
    places: array[int] = field(default_factory=lambda: array("Q"))  # where its messages begin
    instance: str | None = None  # column that tells sensors of one kind apart

    def rows(self, content: bytes) -> NDArray[Any]:
        """All its messages."""
        dtype = np.dtype([("", "V3"), *((name, _TYPES[letter]) for name, letter in self.columns.items())])
        return np.frombuffer(b"".join([content[at : at + self.length] for at in self.places]), dtype)


def read_ardupilot_log(file: Path) -> FlightLog:
    content = read_bytes(file, LARGEST_LOG, RecordingError)
    kinds, bad = _kinds(content)
    logged = {name: rows for kind in kinds for name, rows in _logged(kind, content)}
    return flight_log("ardupilot", file, logged, bad)


def _kinds(content: bytes) -> tuple[list[_Kind], int]:
    kinds = {
        _FORMAT_KIND: _Kind("FMT", 89, dict(zip(("Type", "Length", "Name", "Format", "Columns"), "BBnNZ", strict=True)))
    }
    place = bad = 0
    while place < len(content):
        kind = _kind_at(content, place, kinds)
        follower = place + kind.length if kind is not None else place
        if kind is None or not _ends_well(content, follower):
            found = _next(content, place + 1, kinds)
            if kind is None or (found is not None and found < follower):  # it has swallowed a whole one
                if found is None:
                    break
                bad, place = bad + 1, found
                continue
        if kind.name == "FMT":
            bad += not _learn(content[place + 3 : follower], kinds)
        kind.places.append(place)
        place = follower
    _name_instances(kinds, content)
    return [kind for kind in kinds.values() if kind.places], bad


def _kind_at(content: bytes, place: int, kinds: Mapping[int, _Kind]) -> _Kind | None:
    """Kind of the message that begins at a place, if one does."""
    kind = kinds.get(content[place + 2]) if content.startswith(_HEAD, place) and place + 2 < len(content) else None
    return kind if kind is not None and place + kind.length <= len(content) else None


def _ends_well(content: bytes, place: int) -> bool:
    return place == len(content) or content.startswith(_HEAD, place)


def _next(content: bytes, place: int, kinds: Mapping[int, _Kind]) -> int | None:
    """Where the next message begins that another one follows."""
    while (place := content.find(_HEAD, place)) >= 0:
        kind = _kind_at(content, place, kinds)
        if kind is not None and _ends_well(content, place + kind.length):
            return place
        place += 1
    return None


def _learn(body: bytes, kinds: dict[int, _Kind]) -> bool:
    """Take in what a FMT message says; False if that makes no sense, or is something else than before."""
    number, length = body[:2]
    name, letters, columns = (part.split(b"\0")[0] for part in (body[2:6], body[6:22], body[22:]))
    names = columns.split(b",") if columns else []
    if not all(map(_NAME.fullmatch, (name, *names))) or len(set(names)) < len(names) or len(names) != len(letters):
        return False
    made = dict(zip((one.decode() for one in names), letters.decode("latin-1"), strict=True))
    if not set(made.values()) <= _TYPES.keys():
        return False
    if length != 3 + sum(np.dtype(_TYPES[one]).itemsize for one in made.values()):
        return False
    before = kinds.setdefault(number, _Kind(name.decode(), length, made))
    return (before.name, before.length, before.columns) == (name.decode(), length, made)


def _name_instances(kinds: Mapping[int, _Kind], content: bytes) -> None:
    """FMTU messages mark the column of the instance with `#`."""
    units = next((kind for kind in kinds.values() if kind.name == "FMTU"), None)
    if units is None or not {"FmtType", "UnitIds"} <= set(units.columns):
        return
    for row in units.rows(content):
        kind, marks = kinds.get(int(row["FmtType"])), bytes(row["UnitIds"])
        if kind is not None and 0 <= marks.find(b"#") < len(kind.columns):
            kind.instance = list(kind.columns)[marks.find(b"#")]


def _logged(kind: _Kind, content: bytes) -> Iterator[tuple[str, LogRows]]:
    """Topics of a kind; sensors of one kind are told apart by their instance."""
    if kind.columns.get(_TIME) != "Q":
        return
    rows = kind.rows(content)
    columns = {name: _column(rows[name], letter) for name, letter in kind.columns.items() if name != _TIME}
    if kind.instance is None or kind.instance == _TIME:
        yield f"ardupilot/{kind.name}", LogRows(rows[_TIME], columns)
        return
    for value in np.unique(columns[kind.instance]):
        own = columns[kind.instance] == value
        fields = {name: one[own] for name, one in columns.items()}
        yield f"ardupilot/{kind.name}_{value}", LogRows(rows[_TIME][own], fields)


def _column(values: NDArray[Any], letter: str) -> NDArray[Any]:
    """Numbers in their units, and texts."""
    if values.dtype.kind == "S":
        return texts(values.tolist())
    return np.asarray(values / _DIVISORS[letter]) if letter in _DIVISORS else values
