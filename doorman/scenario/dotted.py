"""Nested tables by dotted key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def leaves(tables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values that are no tables."""
    for name, value in tables.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def put(tables: dict[str, Any], key: str, value: Any) -> str:
    """Set a value; where a part of the key is no table, nothing is set, and that part returned."""
    *sections, last = key.split(".")
    for section in sections:
        tables = tables.setdefault(section, {})
        if not isinstance(tables, dict):
            return section
    tables[last] = value
    return ""
