"""Checks of numbers and arrays that come from outside: type, shape and finiteness. Text, bool and complex are no numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from numbers import Real
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.exceptions import BackendError, DimensionError, shown

_FLOAT = np.dtype(np.float64)


def vector(values: ArrayLike, size: int, field: str) -> NDArray[np.float64]:
    """A fresh float vector of the right length with finite entries."""
    if type(values) is np.ndarray and values.dtype is _FLOAT and values.shape == (size,):
        if math.isfinite(sum(values.tolist())):  # as in nearly every call; a sum may overflow, and is looked at below
            return values.copy()
    plain = isinstance(values, tuple) and set(map(type, values)) == {float}
    array = np.array(values) if plain else numbers(values, field, f"shape ({size},)")
    if array.shape != (size,):
        raise DimensionError("wrong shape", field=field, given=array.shape, allowed=f"({size},)")
    if not all(map(math.isfinite, array.tolist())):  # faster than numpy's for short vectors
        index = int(np.flatnonzero(~np.isfinite(array))[0])
        where, given = f"{field}[{index}]", float(array[index])
        raise DimensionError("not finite", field=where, given=given, allowed="finite numbers")
    return array


def components(values: ArrayLike, size: int, field: str) -> list[float]:
    """Numbers of a checked `vector`, as a list of floats."""
    if type(values) is np.ndarray and values.dtype is _FLOAT and values.shape == (size,):
        found: list[float] = values.tolist()
        if math.isfinite(sum(found)):
            return found
    checked: list[float] = vector(values, size, field).tolist()
    return checked


def numbers(values: ArrayLike, field: str, allowed: str = "an array of numbers") -> NDArray[np.float64]:
    """A fresh, contiguous float array of any shape, finite or not."""
    try:
        if _are_numbers(values):
            return np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError, RecursionError):  # ragged, beyond floats, or a list that holds itself
        pass
    raise DimensionError("not an array of numbers", field=field, given=shown(values), allowed=allowed)


def number(value: Any, field: str, allowed: str = "a finite number") -> float:
    """A finite number."""
    if type(value) is float and math.isfinite(value):
        return value
    try:
        many = isinstance(value, (list, tuple)) or np.ndim(value)
        found = math.nan if many else float(numbers(value, field, allowed))
    except ValueError as error:  # of an array whose rows differ in length
        raise DimensionError("not a number", field=field, given=shown(value), allowed=allowed) from error
    if not math.isfinite(found):
        raise DimensionError("not a finite number", field=field, given=value, allowed=allowed)
    return found


def positive(value: Any, field: str) -> float:
    """A time above zero [s]."""
    found = number(value, field, "> 0 s")
    if found <= 0.0:
        raise DimensionError("not above zero", field=field, given=value, allowed="> 0 s")
    return found


_MOST = 2**63 - 1
"""Largest integer that kernels and random generators take."""


def whole(value: Any, field: str, least: int) -> int:
    """A whole number of 64 bits, not below a least one; 3.0 is none."""
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool) and least <= value <= _MOST:
        return int(value)
    raise DimensionError("not a whole number", field=field, given=value, allowed=f"an integer >= {least}, of 64 bits")


def _are_numbers(values: Any) -> bool:
    if isinstance(values, (list, tuple)):
        return all(map(_are_numbers, values))
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    if kind is None:
        if hasattr(values, "__array__"):
            return _are_numbers(np.asarray(values))
        return isinstance(values, Real) and not isinstance(values, bool)
    return kind in "iuf" or (kind == "O" and all(map(_are_numbers, np.asarray(values).ravel().tolist())))


def per_node(values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Numbers for every node, checked."""
    given = np.asarray(values, dtype=np.float64)
    if given.shape not in (shape, shape[1:]) or not np.isfinite(given).all():
        raise DimensionError(
            "not parameters of the nodes", field="node_parameters", given=given.shape,
            allowed=f"finite numbers of shape {shape} or {shape[1:]}",
        )  # fmt: skip
    return np.broadcast_to(given, shape)


@dataclass(frozen=True)
class Range:
    """What a number of a dataclass may be, written with its type: `rate: Annotated[float, Range(10.0, 2000.0, "1/s")]`."""

    low: float
    high: float = math.inf
    unit: str = ""
    above: bool = False  # whether the low end is out of range itself

    def holds(self, value: float) -> bool:
        return math.isfinite(value) and self.low <= value <= self.high and not (self.above and value == self.low)

    def __str__(self) -> str:
        words = f"{self.low:g} to {self.high:g}"
        if self.high == math.inf:
            words = f"{'>' if self.above else '>='} {self.low:g}"
        return f"{words} {self.unit}".rstrip()


Positive = Annotated[float, Range(0.0, above=True)]
NonNegative = Annotated[float, Range(0.0)]


def check_rules(settings: Any, prefix: str, *rules: tuple[bool, str, str]) -> None:
    """Refuse settings of which a rule does not hold: whether it does, the field that it is about, and what is allowed."""
    for good, name, allowed in rules:
        if not good:
            raise BackendError("out of range", field=prefix + name, given=getattr(settings, name), allowed=allowed)


def check_fields(settings: Any, prefix: str = "") -> None:
    """Hold the fields of a dataclass of settings against the ranges and choices in their types; None is allowed to be none."""
    kind: Any = type(settings)  # which mypy takes for hashable
    for name, allowed in _allowed(kind).items():
        value = getattr(settings, name)
        if isinstance(allowed, Range):
            if value is not None and not allowed.holds(value):
                raise BackendError("out of range", field=prefix + name, given=value, allowed=str(allowed))
        elif value not in allowed:
            raise BackendError("unknown choice", field=prefix + name, given=value, allowed=" or ".join(allowed))


@cache
def _allowed(settings: type) -> dict[str, Range | tuple[str, ...]]:
    """Range or choices of the fields that have some."""
    found: dict[str, Range | tuple[str, ...]] = {}
    for name, hint in get_type_hints(settings, include_extras=True).items():
        for one in (hint, *get_args(hint)):
            if get_origin(one) is Literal:
                found[name] = get_args(one)
            for note in getattr(one, "__metadata__", ()):
                if isinstance(note, Range):
                    found[name] = note
    return found
