"""Single settings of the links by name, such as `pixhawk.vehicle_system`, `servos.baud_rate` or `mocap.sender`."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar, get_type_hints

from numpy.typing import ArrayLike
from pydantic import TypeAdapter, ValidationError

from doorman.exceptions import BackendError

GIVEN = frozenset(
    {
        "pixhawk.mocap", "pixhawk.listen_only", "pixhawk.on_mocap_loss", "pixhawk.rotors", "servos.gripper",
        "servos.lower_limits", "servos.upper_limits", "servos.rate_limits", "door_sensor.motion",
    }
)  # fmt: skip
"""What follows from the scenario and from the links themselves."""
Config = TypeVar("Config")


def with_settings(config: Config, settings: Mapping[str, object], prefix: str = "") -> Config:
    """A configuration with other values for some of its settings."""
    tree: dict[str, Any] = {}
    for name, value in settings.items():
        if part := next((other for other in settings if other.startswith(f"{name}.")), ""):
            raise BackendError(f"set twice: as a whole, and in part as {part}", field=name, given=value)
        *path, last = name.split(".")
        branch = tree
        for part in path:
            branch = branch.setdefault(part, {})
        branch[last] = value
    return _changed(config, tree, prefix)


def _changed(config: Config, tree: Mapping[str, Any], prefix: str) -> Config:
    fields = [one.name for one in dataclasses.fields(config) if one.init]  # type: ignore[arg-type]
    hints, values = get_type_hints(type(config)), {}
    for name, value in tree.items():
        field = f"{prefix}{name}"
        if name not in fields:
            raise BackendError("no such setting", field=field, allowed=", ".join(fields))
        if field in GIVEN:
            raise BackendError(
                "cannot be set: doorman derives it from the scenario and the links", field=field, given=value
            )
        current = getattr(config, name)
        if current is None and not prefix:
            raise BackendError("there is no such link", field=field, given=value)
        if isinstance(value, Mapping) and dataclasses.is_dataclass(current):
            values[name] = _changed(current, value, f"{field}.")
        elif hints[name] == ArrayLike:
            values[name] = value
        else:
            values[name] = _of_type(hints[name], value, field)
    return dataclasses.replace(config, **values)  # type: ignore[type-var]


def _of_type(hint: Any, value: object, field: str) -> Any:
    try:
        return TypeAdapter(hint).validate_python(value)
    except ValidationError as error:
        words = "; ".join(dict.fromkeys(one["msg"] for one in error.errors()))
        raise BackendError("wrong value", field=field, given=value, allowed=words) from error
