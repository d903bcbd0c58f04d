"""Reality: presets of what disturbs a simulated flight without the planner's and the estimate's knowledge."""

from __future__ import annotations

import copy
import functools
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any, Literal, get_args

from pydantic import BaseModel

from doorman.resources import scenario_directory, shipped
from doorman.scenario.sections.campaign import distributions
from doorman.scenario.values import Section

Preset = Literal["mild", "rough", "hostile"]
"""A careful laboratory, an ordinary hall, and conditions that are too hard for a real flight."""
_FOLDER = "presets"
_VARY = "vary"


class RealitySection(Section):
    """Whether a preset sets and draws keys of `[simulation]`; what the scenario gives itself wins."""

    preset: Preset | None = None
    """`"mild"`, `"rough"` or `"hostile"`: sets keys of `[simulation]`, and draws them in a campaign
    (docs/reality.md#presets). What the scenario or `--set` gives itself wins. Default: none."""


def under(tables: Any) -> Any:
    """The tables of a scenario with those of its preset beneath them."""
    reality = _table(tables.get("reality")) if isinstance(tables, Mapping) else None
    preset = None if reality is None else reality.get("preset")
    if preset not in get_args(Preset):
        return tables
    base = copy.deepcopy(_read(str(preset)))
    given = {name: _as_table(value) for name, value in tables.items()}
    campaign = given.setdefault("campaign", {})
    if not isinstance(campaign, dict):
        return tables
    named = {key for key, _ in _leaves(given)}
    for key, value in _leaves(base["simulation"], "simulation."):
        if key not in named:
            _set(given, key, value)
    vary = campaign.setdefault(_VARY, {})
    if isinstance(vary, dict):
        drawn = distributions(vary)
        for key, distribution in distributions(base[_VARY]).items():
            if key not in named and key not in drawn:
                vary[key] = distribution
    return given


@functools.cache
def _read(preset: str) -> dict[str, Any]:
    path = shipped(scenario_directory() / _FOLDER, ".toml")[preset]
    return tomllib.loads(path.read_text(encoding="utf-8"))


def _table(value: Any) -> Mapping[str, Any] | None:
    table = _as_table(value)
    return table if isinstance(table, Mapping) else None


def _as_table(value: Any) -> Any:
    """A section as the table of what was set in it; a table as a copy of its own."""
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_unset=True)
    return {key: _as_table(item) for key, item in value.items()} if isinstance(value, Mapping) else value


def _leaves(tables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values by dotted key."""
    for name, value in tables.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _set(tables: dict[str, Any], key: str, value: Any) -> None:
    """Set a dotted key; where a table is none, its own check says so."""
    *sections, last = key.split(".")
    for section in sections:
        tables = tables.setdefault(section, {})
        if not isinstance(tables, dict):
            return
    tables[last] = value
