"""A recording's header: as JSON, as texts of a metadata record, and its JSON schema."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from doorman.exceptions import RecordingError, shown

HEADER = "header"
"""Topic whose only message is the header, and name of its metadata record."""
_PLAIN = ("boolean", "string", "number")


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


def header_value(text: str) -> Any:
    """Value of the header from the text in its metadata record."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def header_text(value: Any) -> str:
    """Text of a value of the header: the words themselves where they are no JSON, so that they read well."""
    return value if isinstance(value, str) and header_value(value) is value else json.dumps(value)
