"""Tables of a vehicle file: sections of a scenario, and the fields of the links' own configurations, closed to other keys."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import GenericAlias, NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from numpy.typing import ArrayLike
from pydantic import Field, create_model

from doorman.hardware.dynamixel import ServoConfig
from doorman.hardware.mocap import MocapConfig
from doorman.hardware.pixhawk import PixhawkConfig
from doorman.hardware.vehicle import VehicleConfig
from doorman.hardware.vehicle.settings import GIVEN
from doorman.scenario import ControlSection, EstimationSection, LimitsSection, SafetySection, VehicleSection
from doorman.scenario.values import Name, Number, Section, Switch

LINKS: dict[str, type] = {"pixhawk": PixhawkConfig, "servos": ServoConfig, "mocap": MocapConfig}
"""Configuration by the name of its table."""
GAINS: dict[str, type[Section]] = {
    "control": ControlSection, "estimation": EstimationSection, "limits": LimitsSection, "safety": SafetySection,
}  # fmt: skip
"""Sections of a scenario of which a vehicle may have its own values."""
VEHICLE = "vehicle"
"""Table that takes the place of the scenario's where it names a URDF."""
_PLAIN: dict[Any, Any] = {float: Number, int: Annotated[int, Field(strict=True)], bool: Switch, str: Name, Path: Path}


def _section(config: type, prefix: str, whole: bool) -> type[Section]:
    """Table with the fields of a configuration."""
    keys: dict[str, Any] = {}
    hints = get_type_hints(config)
    for field in dataclasses.fields(config):
        if not field.init or f"{prefix}{field.name}" in GIVEN:
            continue
        required = whole and field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        keys[field.name] = (_checked(hints[field.name], f"{prefix}{field.name}."), ... if required else None)
    return create_model(config.__name__, __base__=Section, __doc__=config.__doc__, **keys)


def _checked(hint: Any, prefix: str) -> Any:
    """Type of a key: what is not set has no key, so that None is none of its values."""
    if hint == ArrayLike:
        return tuple[Number, ...]
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return _section(hint, prefix, whole=True)
    if hint in _PLAIN:
        return _PLAIN[hint]
    if get_origin(hint) in (Union, UnionType):
        (only,) = (one for one in get_args(hint) if one is not NoneType)
        return _checked(only, prefix)
    if get_origin(hint) is tuple:
        return GenericAlias(tuple, tuple(one if one is ... else _checked(one, prefix) for one in get_args(hint)))
    return hint


def _tables() -> type[Section]:
    hints = get_type_hints(VehicleConfig)
    keys: dict[str, Any] = {
        field.name: (_checked(hints[field.name], f"{field.name}."), None)
        for field in dataclasses.fields(VehicleConfig)
        if field.name not in LINKS
    }
    keys[VEHICLE] = (VehicleSection, VehicleSection())
    for name, config in LINKS.items():
        section = _section(config, f"{name}.", whole=False)
        keys[name] = (section, Field(default_factory=section))
    keys |= {name: (section, section()) for name, section in GAINS.items()}
    return create_model("VehicleTables", __base__=Section, **keys)


TABLES = _tables()
"""All that a vehicle file may hold."""
