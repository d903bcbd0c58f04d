"""Bounds of whatever is read from outside: the grammar of numbers, sizes, depth. Every reader of files takes them from here."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from doorman.exceptions import DoormanError

DEEPEST = 32
"""Tables or lists inside each other."""
LARGEST_TEXT = 10_000_000
"""Largest URDF or JSON file [bytes]."""
LARGEST_TABLES = 1_000_000
"""Largest TOML file [bytes]."""
LARGEST_LOG = 2**31
"""Largest recording or autopilot's log, and sum of a recording's decompressed chunks [bytes]."""
LARGEST_CHUNK = 2**26
"""Largest decompressed chunk of a recording, and so of a message [bytes]."""
LONGEST = 6 * 3600.0
"""Longest flight: a message farther from the middle of a log has a wrong time [s]."""
LAST_TIME = 1e10
"""Latest time in a recording: MCAP counts nanoseconds in 64 bits [s]."""
_LONGEST_NUMBER = 100
"""Characters of a number."""
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_BLANKS = re.compile(r"[ \t\r\n]+")
_LONGEST_INTEGER = 4096
"""Longest integer in tables [bits]; Python does not print much longer ones."""
_PARTS = re.compile(r"[=,{}\[\]\n]")
"""Between them stands a key or a value of TOML."""
_ELLIPSIS = re.compile(r"\.\.+")
_MOST_DOTS = 100
"""In a key or value, before it is parsed: of a key, `tomllib` needs the square of them."""


def parse_number(text: str) -> float:
    """A decimal number of ASCII digits, as XML, C and C++ read it; Python's float() reads `1_0` and other scripts' digits."""
    value = float(text) if len(text) <= _LONGEST_NUMBER and _NUMBER.fullmatch(text) else float("inf")
    if value in (float("inf"), -float("inf")):
        raise ValueError(f"not a number: {text[:40]!r}")
    return value


def parse_numbers(text: str) -> list[float]:
    """Numbers with blanks between them."""
    return [parse_number(word) for word in _BLANKS.split(text) if word]


def read_bytes(path: Path, largest: int, error: type[DoormanError] = DoormanError) -> bytes:
    """Content of a file of bounded size."""
    try:
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except OSError as fault:
        raise error(f"cannot be read: {fault.strerror}", file=path, field="file", given=str(path)) from fault
    if len(content) > largest:
        raise error("too large a file", file=path, field="file", given=f"more than {largest} bytes",
                    allowed=f"up to {largest} bytes")  # fmt: skip
    return content


def read_json(path: Path) -> dict[str, Any]:
    """The object that a JSON file holds."""
    try:
        found = json.loads(read_bytes(path, LARGEST_TEXT))
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise DoormanError("damaged: not JSON", file=path, allowed="the file as doorman wrote it; or remove it")
    return found


def parse_toml(text: str, error: type[DoormanError], file: Path | None = None) -> dict[str, Any]:
    """Tables of TOML 1.0."""
    dots = max(part.count(".") for part in _PARTS.split(_ELLIPSIS.sub("", text)))
    if dots > _MOST_DOTS:
        raise error("nested too deep", file=file, given=f"a key of {dots + 1} parts", allowed=f"up to {DEEPEST} tables")
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as fault:  # syntax, digits or nesting beyond Python's limits
        raise error(f"not valid TOML: {fault}", file=file, allowed="TOML 1.0 in UTF-8") from fault
    check_tables(tables, error, file)
    return tables


def check_tables(tables: Mapping[str, Any], error: type[DoormanError], file: Path | None = None) -> None:
    """Check that tables are not too deep, and that their integers can be printed."""
    waiting: list[tuple[str, int, Any]] = [("", 0, tables)]
    while waiting:  # the last one first: a list that holds itself is soon too deep
        key, depth, value = waiting.pop()
        if depth > DEEPEST:
            raise error("nested too deep", file=file, field=key[:80], allowed=f"up to {DEEPEST} tables or lists")
        if isinstance(value, int) and value.bit_length() > _LONGEST_INTEGER:
            raise error("too large an integer", file=file, field=key, given=value, allowed=f"{_LONGEST_INTEGER} bits")
        inside: Iterable[tuple[Any, Any]] = ()
        if isinstance(value, Mapping):
            inside = value.items()
        elif isinstance(value, (list, tuple)):
            inside = enumerate(value)
        waiting += ((f"{key}.{name}" if key else str(name), depth + 1, one) for name, one in inside)
