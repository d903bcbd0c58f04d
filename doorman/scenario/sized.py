"""Defaults that grow with the vehicle, forces as its weight, torques as weight and length; and those that no hover measures.

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


def unmeasured(scenario: Scenario) -> Scenario:
    """The scenario with the plant's attitude loop where whole-body plans of a grip start in contact: no hover measures it."""
    if not starts_tied(scenario):
        return scenario
    true, vehicle = scenario.simulation, scenario.vehicle
    loop = {"attitude_lag": true.attitude_lag, "attitude_dead_time": true.attitude_dead_time}
    believed = {key: value for key, value in loop.items() if key not in vehicle.model_fields_set}
    return scenario.model_copy(update={"vehicle": vehicle.model_copy(update=believed)})


def starts_tied(scenario: Scenario) -> bool:
    """Whether whole-body plans begin with a grip that no hover comes before."""
    in_the_grip = scenario.mission.start == "contact" and scenario.contact.kind == "grip"
    return in_the_grip and scenario.planner.model == "whole_body"


def _sized(section: Section, ratios: Mapping[tuple[str, ...], float]) -> dict[str, Any]:
    """New values of a section: of its keys that were not given, and of the sections in it."""
    changed: dict[str, Any] = {}
    for name in dict.fromkeys(path[0] for path in ratios):
        value = getattr(section, name)
        inner = {path[1:]: ratio for path, ratio in ratios.items() if path[0] == name}
        if () not in inner:
            changed[name] = value.model_copy(update=_sized(value, inner))
        elif name not in section.model_fields_set:
            changed[name] = inner[()] * value
    return changed
