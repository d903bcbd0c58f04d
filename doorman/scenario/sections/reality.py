"""Reality: presets of what disturbs a simulated flight without the planner's and the estimate's knowledge."""

from __future__ import annotations

import copy
import functools
import tomllib
from collections.abc import Mapping
from typing import Any, Literal, get_args

from pydantic import BaseModel

from doorman.resources import scenario_directory, shipped
from doorman.scenario.dotted import leaves, put
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
    given = _as_table(tables)
    match given:
        case {"reality": {"preset": str(preset)}} if preset in get_args(Preset):
            base = copy.deepcopy(_read(preset))
        case _:
            return tables
    named = {key for key, _ in leaves(given)}
    for key, value in leaves(base["simulation"], "simulation."):
        if key not in named:
            put(given, key, value)  # where a table is none, its own check says so
    campaign = given.setdefault("campaign", {})
    vary = campaign.setdefault(_VARY, {}) if isinstance(campaign, dict) else None
    if isinstance(vary, dict):
        drawn = named | set(distributions(vary))
        vary |= {key: value for key, value in distributions(base[_VARY]).items() if key not in drawn}
    return given


@functools.cache
def _read(preset: str) -> dict[str, Any]:
    path = shipped(scenario_directory() / _FOLDER, ".toml")[preset]
    return tomllib.loads(path.read_text(encoding="utf-8"))


def _as_table(value: Any) -> Any:
    """A section as the table of what was set in it; a table as a copy of its own."""
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_unset=True)
    return {key: _as_table(item) for key, item in value.items()} if isinstance(value, Mapping) else value
