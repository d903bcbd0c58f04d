"""Tables of a vehicle file, and its template: keys, defaults and comments are those of the classes that take the values."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import GenericAlias, NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from numpy.typing import ArrayLike
from pydantic import Field, create_model

from doorman.docstrings import field_docs
from doorman.hardware.dynamixel import ServoConfig
from doorman.hardware.mocap import MocapConfig
from doorman.hardware.pixhawk import PixhawkConfig
from doorman.hardware.vehicle import VehicleConfig, vehicle_config
from doorman.hardware.vehicle.config import DOOR_SENSOR, GIVEN
from doorman.model import Model
from doorman.scenario import ControlSection, EstimationSection, LimitsSection, SafetySection, Scenario, VehicleSection
from doorman.scenario.plain import plain
from doorman.scenario.toml_text import value_text
from doorman.scenario.values import Name, Number, Section, Switch

LINKS: dict[str, type] = {"pixhawk": PixhawkConfig, "servos": ServoConfig, "mocap": MocapConfig}
"""Configuration by the name of its table."""
GAINS: dict[str, type[Section]] = {
    "control": ControlSection, "estimation": EstimationSection, "limits": LimitsSection, "safety": SafetySection,
}  # fmt: skip
"""Sections of a scenario of which a vehicle may have its own values."""
VEHICLE = "vehicle"
"""Table that takes the place of the scenario's where it names a URDF."""
_Keys = dict[str, tuple[Any, str]]
"""Default and docstring by dotted key."""
_PLAIN: dict[Any, Any] = {float: Number, int: Annotated[int, Field(strict=True)], bool: Switch, str: Name, Path: Path}


def _table_of(config: type, prefix: str, whole: bool) -> type[Section]:
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
        return _table_of(hint, prefix, whole=True)
    if hint in _PLAIN:
        return _PLAIN[hint]
    if get_origin(hint) in (Union, UnionType):
        (only,) = (one for one in get_args(hint) if one is not NoneType)
        return _checked(only, prefix)
    if get_origin(hint) is tuple:
        return GenericAlias(tuple, tuple(one if one is ... else _checked(one, prefix) for one in get_args(hint)))
    return hint


def _all_tables() -> type[Section]:
    hints = get_type_hints(VehicleConfig)
    keys: dict[str, Any] = {
        field.name: (_checked(hints[field.name], f"{field.name}."), None)
        for field in dataclasses.fields(VehicleConfig)
        if field.name not in LINKS
    }
    keys[VEHICLE] = (VehicleSection, VehicleSection())
    for name, config in LINKS.items():
        section = _table_of(config, f"{name}.", whole=False)
        keys[name] = (section, Field(default_factory=section))
    keys |= {name: (section, section()) for name, section in GAINS.items()}
    return create_model("VehicleTables", __base__=Section, **keys)


TABLES = _all_tables()
"""All that a vehicle file may hold."""


_WIDTH = 100
_HEAD = """\
A vehicle, whatever its task: doorman fly paper --vehicle {name}
Angles in rad, everything else in SI units. Paths are relative to this file. The command line wins over it.
What has a # in front is the default."""
_FROM_THE_MODEL = {
    "pixhawk.hover_force": "By default from the URDF's mass.",
    "pixhawk.min_battery": "By default safety.low_battery.",
}
"""What is said of keys whose default is another value for each vehicle or task."""
_WITHOUT_DEFAULTS = ("pixhawk.thrust_curve", DOOR_SENSOR)
"""Tables that are not there until something is measured."""
_ABOUT = {
    VEHICLE: "It takes the place of the scenario's [vehicle].",
    "pixhawk": "The link to the autopilot.",
    "servos": "Servos from base to tip, then the gripper's; a task that only pushes leaves the last one alone.",
    "mocap": 'The cameras; connection = "none" flies by the autopilot\'s own estimate.',
    DOOR_SENSOR: "What measures the door; docs/how-to/measure_the_door.md.",
    **{name: f"What differs from the scenario's [{name}]." for name in GAINS},
}
_WRITTEN_BY = {
    "servos.zero_positions": "doorman vehicle zeros",
    "mocap.object_position": "doorman vehicle object",
    "mocap.object_attitude": "doorman vehicle object",
    "mocap.origin_position": "doorman vehicle origin",
    "mocap.origin_attitude": "doorman vehicle origin",
    "pixhawk.thrust_curve.hover_thrust": "doorman vehicle learn",
    "pixhawk.thrust_curve.hover_force": "doorman vehicle learn",
}
"""Calibration by the key that it writes."""


def vehicle_template(
    name: str, urdf: str, joints: Sequence[str], names: Mapping[str, str] | None = None, every_key: bool = False
) -> str:
    """Text of a vehicle file that can be flown with once its links are right.

    Args:
        name: Name of the file, for its first line.
        urdf: As it stands in the file.
        joints: Names of the arm's joints from base to tip.
        names: `base_link` and `tip`, where they differ from the defaults.
        every_key: Whether all other keys follow as comments with their defaults.

    Returns:
        The text.
    """
    n = len(joints) + 1  # and the gripper's
    set_keys: dict[str, Any] = {
        "vehicle.urdf": urdf,
        "vehicle.base_link": (names or {}).get("base_link", VehicleSection().base_link),
        "vehicle.tip": (names or {}).get("tip", VehicleSection().tip),
        "pixhawk.connection": "serial:/dev/pixhawk:921600",
        "pixhawk.setpoints": "attitude",
        "servos.port": "/dev/servos",
        "servos.ids": list(range(1, n + 1)),
        "servos.directions": [1] * n,
        "servos.zero_positions": [2048] * n,
        "mocap.connection": "udp:51001",
        "mocap.object_name": "vehicle",
        "mocap.rate": 100.0,
        "mocap.object_position": [0.0, 0.0, 0.0],
        "mocap.object_attitude": [0.0, 0.0, 0.0],
    }
    lines = [f"# {line}" for line in _HEAD.format(name=name).splitlines()]
    if not joints:
        set_keys = {key: value for key, value in set_keys.items() if not key.startswith("servos.")}
    order = f"Order: {', '.join([*joints, 'gripper'])}."
    for table, keys in _tables():
        if not (every_key or keys.keys() & set_keys.keys()) or (table == "servos" and not joints):
            continue
        about = _ABOUT.get(table, "")
        if table:
            lines += ["", f"# [{table}]" if table in _WITHOUT_DEFAULTS else f"[{table}]"]
            lines += _comment(f"{about} {order}" if table == "servos" else about)
        lines += [*([""] if about or not table else []), *_keys(table, keys, set_keys, every_key)]
    return "\n".join(lines) + "\n"


def _keys(table: str, keys: _Keys, set_keys: Mapping[str, Any], every_key: bool) -> Iterator[str]:
    for key, (default, doc) in keys.items():
        last = key.removeprefix(f"{table}.")
        written = f" Written by {_WRITTEN_BY[key]}." if key in _WRITTEN_BY else ""
        if key in _FROM_THE_MODEL:
            default, written = None, f" {_FROM_THE_MODEL[key]}"
        if key in set_keys or every_key:
            yield from _comment(f"{doc}{written}")
        if key in set_keys:
            yield f"{last} = {value_text(set_keys[key])}"
        elif every_key:
            yield f"# {last} = {value_text(default)}" if default is not None else f"# {last}: not set"


def _tables() -> Iterator[tuple[str, _Keys]]:
    """Default and docstring by dotted key, table by table, in the order of the file."""
    config = vehicle_config(Model(Scenario()), "udp:14540", "/dev/servos", "udp:51001", on_mocap_loss="report")
    own, *links = _walked("", VehicleConfig, config)
    door = {key: value for name, keys in links if name.startswith(DOOR_SENSOR) for key, value in keys.items()}
    yield own
    yield from _walked(VEHICLE, VehicleSection, VehicleSection())
    yield from (one for one in links if not one[0].startswith(DOOR_SENSOR))
    told = {key: "" if default is None else f" By default {value_text(default)}." for key, (default, _) in door.items()}
    yield DOOR_SENSOR, {key: (None, f"{doc}{told[key]}") for key, (_, doc) in door.items()}  # no sensor, no table
    for name, section in GAINS.items():
        yield from _walked(name, section, section())


def _walked(name: str, owner: type, values: Any) -> Iterator[tuple[str, _Keys]]:
    """Table of a class, with values of an object or its own defaults, then those of the tables in it."""
    hints, docs = get_type_hints(owner), field_docs(owner)
    keys: _Keys = {}
    inner: list[tuple[str, type, Any]] = []
    for field in _names(owner):
        key, value = f"{name}.{field}".removeprefix("."), getattr(values, field, None)
        if key in GIVEN:
            continue
        if (kind := _table_in(hints[field])) is not None:
            inner.append((key, kind, value or kind))
        else:
            keys[key] = (plain(None if value is dataclasses.MISSING else value), docs.get(field, ""))
    yield name, keys
    for one in inner:
        yield from _walked(*one)


def _names(owner: Any) -> list[str]:
    fields = dataclasses.fields(owner) if dataclasses.is_dataclass(owner) else ()
    return [one.name for one in fields if one.init] or list(owner.model_fields)


def _table_in(hint: Any) -> type | None:
    """Class of the values of a key that is a table; None for one that is not."""
    kinds = (one for one in (hint, *get_args(hint)) if isinstance(one, type))
    return next((one for one in kinds if dataclasses.is_dataclass(one) or hasattr(one, "model_fields")), None)


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(text.strip(), _WIDTH)]
