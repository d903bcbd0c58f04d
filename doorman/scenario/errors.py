"""Errors of a scenario's values: what pydantic finds, in words of TOML."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from pathlib import Path
from types import UnionType
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from doorman.exceptions import ScenarioError
from doorman.scenario.gone import gone
from doorman.scenario.units import in_unit, is_angle, unit_of

_ALLOWED = {
    "model_type": "a table",
    "tuple_type": "a list",
    "missing": "a longer list",
    "too_long": "a shorter list",
    "string_too_short": "a name",
    "string_type": "a string",
    "float_type": "a number",
    "int_type": "an integer",
}
"""Words of TOML for what pydantic says in words of Python, by its type of error."""
_BOUNDS = {"le": "less than or equal to", "ge": "greater than or equal to", "lt": "less than", "gt": "greater than"}


def explain(root: type[BaseModel], error: ValidationError, path: Path | None = None) -> ScenarioError:
    """Turn the first of pydantic's findings into one error of ours."""
    found = error.errors(include_url=False)
    first = next((one for one in found if one["type"] == "extra_forbidden"), found[0])  # a slip may leave a key missing
    field = ".".join(str(part) for part in first["loc"])
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] == "missing" and isinstance(first["loc"][-1], str):
        return ScenarioError(f"missing key{more}", file=path, field=field, given=first["input"], allowed="a value")
    if first["type"] != "extra_forbidden":
        said = first["msg"].removeprefix("Input should be ").removeprefix("Value error, ")
        words = _ALLOWED.get(first["type"]) or _range(first, unit_of(root, first["loc"])) or said
        return ScenarioError(f"wrong value{more}", file=path, field=field, given=first["input"], allowed=words)
    if found_gone := gone(field, first["input"], root.__name__):
        key, words = found_gone
        return ScenarioError(f"the key '{key}' is gone: {words}{more}", file=path, field=key, allowed="no such key")
    section: type[BaseModel] = root
    for part in first["loc"][:-1]:
        section = _below(section, str(part))
    keys = list(section.model_fields)
    nearest = difflib.get_close_matches(str(first["loc"][-1]), keys, n=1, cutoff=0.0)[0]
    return ScenarioError(
        f"unknown key; the nearest is '{nearest}'{more}", file=path, field=field, allowed=", ".join(keys)
    )


def _range(found: Mapping[str, Any], unit: str) -> str:
    """The bound that a number is beyond, with its unit; empty for other findings."""
    for name, words in _BOUNDS.items():
        if (bound := found.get("ctx", {}).get(name)) is not None:
            given, hint = found["input"], ""
            if is_angle(unit) and abs(given) > abs(bound) > 0.0:
                hint = f'; {given:g}° are {math.radians(given):.4g} rad, or "{given:g} deg"'
            return f"{words} {in_unit(bound, unit)}{hint}"
    return ""


def _below(section: Any, part: str) -> Any:
    """The section under a key, or the type of the values where there are many: by name, or one after the other."""
    if not hasattr(section, "model_fields"):
        return [kind for kind in get_args(section) if kind is not Ellipsis][-1]
    below = section.model_fields[part].annotation
    if isinstance(below, UnionType):  # a table that may be left out
        return next((kind for kind in get_args(below) if hasattr(kind, "model_fields")), below)
    return below
