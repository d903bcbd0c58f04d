"""Units of a scenario's keys, as their docstrings give them, and angles that are written in degrees."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from doorman.docstrings import field_docs

_UNIT = re.compile(r"\[([^\[\]]+)\](?!\()")
_ANGLE = re.compile(r"(?<![/\w])rad(?![/\w])")
_DEGREES = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?:deg|°)\s*")


def unit_of(root: Any, place: Sequence[str | int]) -> str:
    """Unit of the key at a place below a section; empty where it has none."""
    owner, key = root, ""
    for part in place:
        if not hasattr(owner, "model_fields") or part not in owner.model_fields:
            break
        root, key, owner = owner, str(part), owner.model_fields[part].annotation
    found = _UNIT.search(field_docs(root).get(key, ""))
    return found[1] if found else ""


def with_radians(section: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """A section's values, with angles such as "30 deg" in rad."""
    return {key: _radians(section, key, value) for key, value in values.items()}


def is_angle(unit: str) -> bool:
    """Whether a number in this unit is an angle."""
    return _ANGLE.search(unit) is not None


def in_unit(number: float, unit: str) -> str:
    """A number with its unit, an angle in degrees as well."""
    degrees = f" ({math.degrees(number):.4g}°)" if number and is_angle(unit) else ""
    return f"{number:.4g} {unit}".strip() + degrees


def _radians(section: Any, key: str, value: Any) -> Any:
    if isinstance(value, list):
        return [_radians(section, key, item) for item in value]
    written = _DEGREES.fullmatch(value) if isinstance(value, str) else None
    if written is None or key not in section.model_fields:
        return value
    return math.radians(float(written[1])) if is_angle(unit_of(section, [key])) else value
