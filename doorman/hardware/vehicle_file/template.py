"""Tables of a vehicle file, and its template: keys, defaults and comments are those of the classes that take the values."""

from __future__ import annotations

import dataclasses
import inspect
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import GenericAlias, NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from numpy.typing import ArrayLike
from pydantic import Field, create_model

from doorman.docstrings import field_docs
from doorman.hardware.door import CameraConfig, DoorSensorConfig, Mark
from doorman.hardware.dynamixel import ServoConfig
from doorman.hardware.mocap import MocapConfig
from doorman.hardware.pixhawk import PixhawkConfig, Rates, ThrustCurve, Timeouts
from doorman.hardware.pixhawk.wire.frames import LocalFrame
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
_NESTED = {"local_frame": LocalFrame, "thrust_curve": ThrustCurve, "timeouts": Timeouts, "rates": Rates}
"""Tables of `[pixhawk]`."""
_DOOR = {"": DoorSensorConfig, "leaf.": Mark, "frame.": Mark, "camera.": CameraConfig}
"""What describes the sensor of the door, by the beginning of its keys."""
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
    for table, keys in _tables(every_key, set_keys):
        if table == "servos" and not joints:
            continue
        if not table:
            lines += ["", *_keys(keys, set_keys, every_key)]
            continue
        about = _ABOUT.get(table, "")
        head = f"# [{table}]" if table in _WITHOUT_DEFAULTS else f"[{table}]"
        lines += ["", head, *_comment(f"{about} {order}" if table == "servos" else about)]
        lines += [*([""] if about else []), *_keys(keys, set_keys, every_key)]
    return "\n".join(lines) + "\n"


def _keys(keys: Mapping[str, tuple[Any, str]], set_keys: Mapping[str, Any], every_key: bool) -> Iterator[str]:
    for key, (default, doc) in keys.items():
        last = key.removeprefix(f"{DOOR_SENSOR}.") if key.startswith(DOOR_SENSOR) else key.rpartition(".")[2]
        written = f" Written by {_WRITTEN_BY[key]}." if key in _WRITTEN_BY else ""
        if key in _FROM_THE_MODEL:
            default, written = None, f" {_FROM_THE_MODEL[key]}"
        if key in set_keys:
            yield from _comment(f"{doc}{written}")
            yield f"{last} = {value_text(set_keys[key])}"
        elif every_key:
            yield from _comment(f"{doc}{written}")
            yield f"# {last} = {value_text(default)}" if default is not None else f"# {last}: not set"


def _tables(every_key: bool, set_keys: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, tuple[Any, str]]]]:
    """Default and docstring by dotted key, table by table; without `every_key` only those tables that have a set key."""
    config = vehicle_config(Model(Scenario()), "udp:14540", "/dev/servos", "udp:51001", on_mocap_loss="report")
    if every_key:
        yield "", _of(config, "", exclude=(*LINKS, DOOR_SENSOR))
    tables = list(_section_tables(VehicleSection(), VEHICLE))
    yield from tables if every_key else tables[:1]
    for name in LINKS:
        part = getattr(config, name)
        yield name, _of(part, f"{name}.", exclude=tuple(_NESTED))
        for nested, kind in _NESTED.items() if every_key and name == "pixhawk" else ():
            inner = getattr(part, nested) or kind
            yield f"{name}.{nested}", _of(inner, f"{name}.{nested}.")
    if every_key:
        yield DOOR_SENSOR, dict(_keys_of_the_door())
    for name, section in GAINS.items() if every_key else ():
        yield from _section_tables(section(), name)


def _keys_of_the_door() -> Iterator[tuple[str, tuple[Any, str]]]:
    """Not set, whatever their defaults: without a sensor of the door there is no table."""
    for part, kind in _DOOR.items():
        for key, (default, doc) in _of(kind, f"{DOOR_SENSOR}.", exclude=("leaf", "frame", "camera")).items():
            words = "" if default is None else f" By default {value_text(default)}."
            yield f"{DOOR_SENSOR}.{part}{key.rpartition('.')[2]}", (None, f"{doc}{words}")


def _section_tables(section: Any, name: str) -> Iterator[tuple[str, dict[str, tuple[Any, str]]]]:
    nested = [key for key in type(section).model_fields if hasattr(getattr(section, key), "model_fields_set")]
    yield name, _of(section, f"{name}.", exclude=tuple(nested))
    for key in nested:
        yield from _section_tables(getattr(section, key), f"{name}.{key}")


def _of(source: Any, prefix: str, exclude: Sequence[str] = ()) -> dict[str, tuple[Any, str]]:
    """Values of an object, or defaults of a class, with the docstrings of its fields."""
    owner: Any = source if inspect.isclass(source) else type(source)
    fields = dataclasses.fields(owner) if dataclasses.is_dataclass(owner) else ()
    names = [one.name for one in fields if one.init] if fields else list(owner.model_fields)
    docs = field_docs(owner)
    return {
        f"{prefix}{name}": (plain(_default(source, name)), docs.get(name, ""))
        for name in names
        if name not in exclude and f"{prefix}{name}" not in GIVEN
    }


def _default(source: Any, name: str) -> Any:
    value = getattr(source, name, None)
    return None if value is dataclasses.MISSING else value


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(text.strip(), _WIDTH)]
