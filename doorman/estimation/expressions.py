"""Checks of what users give for symbols and expressions."""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.exceptions import DimensionError, DoormanError
from doorman.ocp.problem.columns import column


def checked_symbols(field: str, given: Any) -> Any:
    """A column of SX symbols."""
    if not (isinstance(given, ca.SX) and given.is_column() and (given.is_empty() or given.is_valid_input())):
        raise DoormanError("not symbols", field=field, given=type(given).__name__, allowed="a column of casadi.SX.sym")
    return given


def checked_column(field: str, given: Any, known: Any, size: int | None = None) -> Any:
    """A dense column of known symbols."""
    entries = column(field, given)
    unknown = [str(symbol) for symbol in ca.symvar(entries) if not ca.depends_on(known, symbol)]
    if unknown:
        allowed = ", ".join(str(symbol) for symbol in ca.symvar(known))
        raise DoormanError("unknown symbols", field=field, given=", ".join(unknown), allowed=allowed)
    if size is not None and entries.numel() != size:
        raise DimensionError("wrong number of rows", field=field, given=entries.numel(), allowed=str(size))
    return entries


def checked_name(field: str, name: str) -> None:
    """A name that a kernel can bear."""
    if not (isinstance(name, str) and name.isidentifier()):
        raise DoormanError("not a name", field=field, given=name, allowed="letters, digits and _")


def checked_names(field: str, names: list[str]) -> None:
    """Names that differ."""
    for name in names:
        checked_name(field, name)
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DoormanError("names must differ", field=field, given=", ".join(twice))
