"""The scenario that was really flown, file and overrides together, as TOML."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from doorman.resources import shipped, urdf_directory
from doorman.scenario import Scenario


def effective_toml(scenario: Scenario, postures: Mapping[str, tuple[float, ...]] | None = None) -> str:
    """A scenario as TOML text that loads as the same task from any directory.

    Keys whose default follows from the URDFs and that nobody has set are left out; URDFs that do not ship with doorman are
    written as absolute paths.

    Args:
        scenario: The scenario.
        postures: By key, as the scenario's `Model` proposes them; without them they are proposed anew where it is loaded.

    Returns:
        TOML text.

    Raises:
        ScenarioError: if one of its URDFs does not exist.
    """
    tables: dict[str, Any] = scenario.model_dump(exclude_none=True)
    for key, value in (postures or {}).items():
        section, name = key.split(".")
        tables[section][name] = value
    known = shipped(urdf_directory(), ".urdf").values()
    for section, path in (("vehicle", scenario.vehicle_urdf), ("door", scenario.door_urdf)):
        tables[section]["urdf"] = path.stem if path in known else str(path)
    return "\n".join(_lines(tables, "")).lstrip("\n") + "\n"


def _lines(table: dict[str, Any], name: str) -> list[str]:
    values = {key: value for key, value in table.items() if not isinstance(value, dict)}
    lines = ["", f"[{name}]"] if values and name else []
    lines += [f"{key} = {_value(value)}" for key, value in values.items()]
    for key, value in table.items():
        if isinstance(value, dict):
            lines += _lines(value, f"{name}.{key}" if name else key)
    return lines


def _value(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
