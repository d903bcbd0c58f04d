"""Values written into a vehicle file, whose comments and order stay."""

from __future__ import annotations

import os
import tempfile
import tomllib
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import Any

import tomlkit
from pydantic import BaseModel, ValidationError

from doorman.exceptions import ScenarioError
from doorman.hardware.vehicle_file.tables import TABLES
from doorman.scenario.errors import explain
from doorman.scenario.files import read_tables
from doorman.scenario.plain import plain


def write_values(path: Path, values: Mapping[str, object], tables: type[BaseModel] = TABLES) -> None:
    """Write values into a vehicle file, or a task; everything else in it stays, byte for byte.

    The file is replaced in one step, and only by one that can be read again.

    Args:
        path: The file.
        values: By dotted key; tables that are missing are added at the end.
        tables: What the file may hold: a vehicle file's tables, or a scenario's.

    Raises:
        ScenarioError: if the file is malformed or cannot be written, or a value does not fit its key.
    """
    read_tables(path)  # says what is wrong with it
    document = tomlkit.parse(path.read_text(encoding="utf-8-sig"))
    for key, value in values.items():
        _set(document, key, plain(value), path)
    text = tomlkit.dumps(document)
    try:
        tables.model_validate(tomllib.loads(text))
    except ValidationError as error:
        raise explain(tables, error, path) from None
    try:
        _replace(path, text)
    except OSError as error:
        raise ScenarioError(f"cannot be written: {error.strerror}", file=path) from error


def _set(document: MutableMapping[str, Any], key: str, value: object, path: Path) -> None:
    *sections, last = key.split(".")
    table: Any = document
    for section in sections:
        table = table.setdefault(section, {})
        if not isinstance(table, MutableMapping):
            raise ScenarioError("wrong value", file=path, field=section, given=table, allowed="a table")
    table[last] = value


def _replace(path: Path, text: str) -> None:
    """Write beside the file, then rename: nobody reads half a file."""
    target = path.resolve()
    descriptor, beside = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with open(descriptor, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(beside, target.stat().st_mode & 0o7777)
        os.replace(beside, target)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise
