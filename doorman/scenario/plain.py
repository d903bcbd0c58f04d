"""Plain values of what Python has beside them: numpy's numbers and arrays, paths, mappings."""

from __future__ import annotations

import os
from collections.abc import Mapping
from numbers import Real
from typing import Any


def plain(value: Any) -> Any:
    """A value as TOML has it, as far as it has it: numbers, texts, lists and tables; anything else as it is."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if callable(tolist := getattr(value, "tolist", None)):  # numpy's, without an import of numpy
        value = tolist()
        return [plain(item) for item in value] if isinstance(value, list) else _builtin(value)
    return value


def _builtin(value: Any) -> Any:
    """A number that Python has no type for, such as `numpy.longdouble`, as a float."""
    return float(value) if isinstance(value, Real) and not isinstance(value, (int, float)) else value
