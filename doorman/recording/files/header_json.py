"""Header of a recording as JSON, and as texts of its metadata record."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from doorman.exceptions import RecordingError, shown
from doorman.recording.files.messages import HEADER


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
