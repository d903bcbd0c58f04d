"""One-line reprs of dataclasses that hold arrays."""

from __future__ import annotations

from dataclasses import fields
from enum import Enum
from typing import Any

_LONGEST = 60
"""Longest repr of a value [characters]; a longer one is cut."""


class OneLine:
    """Base of dataclasses with `repr=False`: fields in order, arrays as their shapes, parts as their types."""

    def __repr__(self) -> str:
        values = (f"{field.name}={_word(getattr(self, field.name))}" for field in fields(self))  # type: ignore[arg-type]
        return f"{type(self).__name__}({', '.join(values)})"


def _word(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Enum):
        return value.name
    if hasattr(value, "shape"):
        return f"array{tuple(value.shape)}".replace(",)", ")")
    if isinstance(value, OneLine) or hasattr(value, "_fields"):
        return f"{type(value).__name__}(…)"
    if isinstance(value, (tuple, list, dict)) and value:
        return f"{type(value).__name__} of {len(value)}"
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
