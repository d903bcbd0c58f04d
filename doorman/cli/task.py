"""The task of a command: a scenario with its overrides, flown by the vehicle of a vehicle file where one is given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.cli.values import parse_overrides
from doorman.model import Model
from doorman.scenario import Scenario


def load_task(source: str, settings: Sequence[str] | None, vehicle: str | None) -> Scenario:
    """The scenario as its vehicle flies it."""
    overrides = parse_overrides(settings)
    return Scenario.load(source, overrides) if vehicle is None else _file(vehicle).scenario(source, overrides)


def vehicle_values(vehicle: str | None) -> dict[str, Any]:
    """What a vehicle file says that is a scenario's, by dotted key."""
    return {} if vehicle is None else _file(vehicle).scenario_values


def check_links(model: Model, vehicle: str | None) -> None:
    """Check what a vehicle file says of its links, for a command that opens none of them."""
    if vehicle is not None:
        _file(vehicle).links_anywhere(model)


def _file(vehicle: str) -> Any:
    from doorman.hardware.vehicle_file import VehicleFile  # needs the extra hardware

    return VehicleFile.load(vehicle)
