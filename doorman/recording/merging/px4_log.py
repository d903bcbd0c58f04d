"""PX4's ULog: topics with their instances, messages in words, and what tells its clock.

A message is its length, its kind and its content; formats say what a topic's data hold. Behind damage, reading goes on at the
next message that its content tells from noise.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from doorman.bounds import DEEPEST, LARGEST_LOG, read_bytes
from doorman.exceptions import RecordingError
from doorman.recording.merging.flight_log import FlightLog, LogRows, flight_log, texts

_FILE_HEAD = 16
_HEAD = struct.Struct("<HB")
"""Head of a message: length of its content, kind."""
_KINDS = frozenset(b"BFIMPQADLCSOR")
_SURE = (b"D", b"S", b"F", b"A")
"""Kinds whose content tells them from noise."""
_LONGEST_TEXT = 2000
"""Longest format or name that is looked for behind damage [bytes]."""
_STAMP = "timestamp"
_FORMAT = re.compile(r"([\w/]+):(.*)", re.DOTALL)
_FIELD = re.compile(r"(\w+)(?:\[([0-9]{1,5})\])? (\w+)")
_TYPES = {
    "int8_t": "i1", "uint8_t": "u1", "int16_t": "<i2", "uint16_t": "<u2", "int32_t": "<i4", "uint32_t": "<u4",
    "int64_t": "<i8", "uint64_t": "<u8", "float": "<f4", "double": "<f8", "bool": "i1", "char": "i1",
}  # fmt: skip
_MOST_FIELDS = _LONGEST_MESSAGE = 65_535
"""Most fields and bytes of a message: its length has 16 bits."""
_SEARCHED = 1 << 20
"""Behind damage, byte by byte [bytes]; farther on, reading resumes at PX4's own marks."""
_MARK = _HEAD.pack(8, ord("S")) + b"\x2f\x73\x13\x20\x25\x0c\xbb\x12"
_LEVELS = ("EMERGENCY", "ALERT", "CRITICAL", "ERROR", "WARNING", "NOTICE", "INFO", "DEBUG")


@dataclass
class _Logged:
    """What is logged under one number."""

    name: str
    dtype: np.dtype[Any]
    largest: int  # length of a message with the padding at its end [bytes]
    messages: list[bytes] = field(default_factory=list)


def read_px4_log(file: Path) -> FlightLog:
    found = _Reader(read_bytes(file, LARGEST_LOG, RecordingError))
    logged: dict[str, LogRows] = {}
    for one in found.logged.values():
        rows = np.frombuffer(b"".join(one.messages), one.dtype)
        if len(rows):
            fields = {name: rows[name] for name in one.dtype.names or () if name != _STAMP}
            logged.setdefault(one.name, LogRows(rows[_STAMP], fields))
    if found.words:
        stamps, words = zip(*found.words, strict=True)
        logged["px4/logged_messages"] = LogRows(np.array(stamps, dtype=np.uint64), {"message": texts(words)})
    return flight_log("px4", file, logged, found.bad)


class _Reader:
    def __init__(self, content: bytes) -> None:
        self._content = content
        self._formats: dict[str, list[tuple[str, int | None, str]]] = {}
        self._appended: list[int] = []  # where data begin that were appended after a crash
        self.logged: dict[int, _Logged] = {}
        self.words: list[tuple[int, bytes]] = []
        self.bad = 0  # how often what came made no sense
        place: int | None = _FILE_HEAD
        while place is not None and place < len(content):
            place = self._step(place)

    def _step(self, place: int) -> int | None:
        end = self._end(place)
        for start in self._appended:
            if place < start < (len(self._content) if end is None else end):
                return start
        found = None
        if end is not None and self._fits(place, end):
            follows = self._end(end)
            sane = end == len(self._content) or (follows is not None and self._fits(end, follows))
            found = None if sane else self._search(place + 1)
            if found is None or found >= end:  # else it has swallowed a whole one
                self.bad += not self._take(self._content[place + 2], self._content[place + _HEAD.size : end])
                return end
        elif end is not None and self._content[place + 2] not in _KINDS and self._is_one(end):
            return end  # of a kind that newer ones write
        found = self._search(place + 1) if found is None else found
        self.bad += found is not None or end is not None  # else it was cut off here
        return found

    def _end(self, place: int) -> int | None:
        """End of the message at a place; None where the file ends before."""
        if place + _HEAD.size > len(self._content):
            return None
        end = place + _HEAD.size + int(_HEAD.unpack_from(self._content, place)[0])
        return end if end <= len(self._content) else None

    def _fits(self, place: int, end: int) -> bool:
        """Whether a message may stand there."""
        kind, body = self._content[place + 2], place + _HEAD.size
        if kind == ord("D"):
            logged = self.logged.get(int.from_bytes(self._content[body : body + 2], "little"))
            return logged is not None and logged.dtype.itemsize <= end - body - 2 <= logged.largest
        return kind in _KINDS and end > body and (kind != ord("S") or self._content[place:end] == _MARK)

    def _is_one(self, place: int) -> bool:
        """Whether a message stands there beyond doubt: its content says so too."""
        end = self._end(place)
        if end is None or not self._fits(place, end):
            return False
        kind, body = self._content[place + 2], self._content[place + _HEAD.size : min(end, place + _LONGEST_TEXT)]
        named = kind == ord("A") and body[3:].decode(errors="replace") in self._formats
        return kind in b"DS" or named or (kind == ord("F") and _fields_of(body.decode(errors="replace")) is not None)

    def _search(self, place: int) -> int | None:
        """Where the next message stands beyond doubt."""
        for start in range(place, min(place + _SEARCHED, len(self._content))):
            if self._content[start + 2 : start + 3] in _SURE and self._is_one(start):
                return start
        found = self._content.find(_MARK, place + _SEARCHED)
        return found if found >= 0 else None

    def _take(self, kind: int, body: bytes) -> bool:
        """Take in a message; False if it makes no sense."""
        if kind == ord("D"):
            logged = self.logged[int.from_bytes(body[:2], "little")]
            logged.messages.append(body[2 : 2 + logged.dtype.itemsize])
        elif kind == ord("F"):
            text = body.decode(errors="replace")
            if (fields := _fields_of(text)) is None:
                return False
            self._formats[text.partition(":")[0]] = fields
        elif kind == ord("A"):
            return self._subscribe(body)
        elif kind == ord("L") and len(body) > 9:
            level = _LEVELS[body[0] - ord("0")] if ord("0") <= body[0] <= ord("7") else "UNKNOWN"
            self.words.append((int.from_bytes(body[1:9], "little"), f"{level}: ".encode() + body[9:]))
        elif kind == ord("B") and len(body) >= 40 and body[8] & 1:
            self._appended = [start for start in struct.unpack_from("<3Q", body, 16) if start > _FILE_HEAD]
        return True

    def _subscribe(self, body: bytes) -> bool:
        """Take in under which number a topic is logged."""
        name = body[3:].decode(errors="replace")
        try:
            flat = self._flat(name, "", [_MOST_FIELDS], DEEPEST)
            largest = sum(np.dtype(type_).itemsize for _, type_ in flat)
            while flat and flat[-1][0].startswith("_padding"):
                flat.pop()
            dtype = np.dtype(flat)
            if largest > _LONGEST_MESSAGE or dict(flat)[_STAMP] != _TYPES["uint64_t"]:
                return False
        except (KeyError, ValueError):  # no such format, or one without an end, a time, or a name for each field
            return False
        self.logged.setdefault(int.from_bytes(body[1:3], "little"), _Logged(f"px4/{name}_{body[0]}", dtype, largest))
        return True

    def _flat(self, name: str, prefix: str, left: list[int], depth: int) -> list[tuple[str, Any]]:
        """Fields of a format with those of the formats in it, by dotted name; it may have so many, so deep."""
        flat: list[tuple[str, Any]] = []
        for type_, count, own in self._formats[name]:
            left[0] -= count or 1
            if left[0] < 0 or depth == 0:
                raise ValueError("a format too large")
            if type_ in _TYPES:
                flat.append((prefix + own, (_TYPES[type_], (count,)) if (count or 1) != 1 else _TYPES[type_]))
                continue
            for index in range(count or 1):
                place = "" if count is None else f"[{index}]"
                flat += self._flat(type_, f"{prefix}{own}{place}.", left, depth - 1)
        return flat


def _fields_of(text: str) -> list[tuple[str, int | None, str]] | None:
    """Type, count and name of a format's fields; None if it is none."""
    found = _FORMAT.fullmatch(text)
    fields = [_FIELD.fullmatch(part) for part in found[2].split(";") if part] if found else [None]
    return None if None in fields else [(one[1], int(one[2]) if one[2] else None, one[3]) for one in fields if one]
