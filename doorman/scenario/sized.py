"""Defaults that grow with the vehicle: forces in proportion to its weight, torques to weight and length.

The defaults of these keys are those of the shipped vehicle and door. What a scenario gives itself stays as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from doorman.scenario.scenario import Scenario
from doorman.scenario.sized_keys import SIZED
from doorman.scenario.values import Section


def sized(scenario: Scenario, ratios: Mapping[str, float]) -> Scenario:
    """A scenario for a vehicle of another size."""
    if all(ratio == 1.0 for ratio in ratios.values()):
        return scenario
    units = {tuple(key.split(".")): ratios[unit] for key, unit in SIZED.items()}
    return scenario.model_copy(update=_sized(scenario, units))


def _sized(section: Section, ratios: Mapping[tuple[str, ...], float]) -> dict[str, Any]:
    """New values of a section: of its keys that were not given, and of the sections in it."""
    changed: dict[str, Any] = {}
    for name in dict.fromkeys(path[0] for path in ratios):
        value = getattr(section, name)
        inner = {path[1:]: ratio for path, ratio in ratios.items() if path[0] == name}
        if () not in inner:
            changed[name] = value.model_copy(update=_sized(value, inner))
        elif name not in section.model_fields_set:
            ratio = inner[()]
            changed[name] = tuple(ratio * each for each in value) if isinstance(value, tuple) else ratio * value
    return changed
