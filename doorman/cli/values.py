"""Values on the command line: overrides of keys, `--set planner.margin=0.01`, and lists of numbers."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable
from typing import Any

from doorman.bounds import parse_toml
from doorman.exceptions import DoormanError, ScenarioError

_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")
_WORD = re.compile(r"[A-Za-z_./~][^\"'\[\]{}=#,\x00-\x1f\x7f]*|\d{1,3}(\.\d{1,3}){3}")
"""What may stand without quotes: a name, a path or an IPv4 address."""


def parse_overrides(settings: Iterable[str] | None, option: str = "--set") -> dict[str, Any]:
    """Values by dotted key from `key=value` texts; the last of a key wins."""
    return dict(_parse(text, option) for text in settings or ())


def _parse(text: str, option: str) -> tuple[str, Any]:
    key, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not _KEY.fullmatch(key):
        raise ScenarioError("not an override", field=option, given=text, allowed="KEY=VALUE with a dotted key")
    try:
        table = parse_toml(f"value = {value}", ScenarioError)
        if table.keys() == {"value"}:  # and no further line smuggled in
            return key, table["value"]
    except ScenarioError:
        if _WORD.fullmatch(value):
            return key, value
    raise ScenarioError(
        "the value is not TOML", field=f"{option} {key}", given=value,
        allowed='a number, true, false, a list such as [0, 1], a word, or a "quoted text"',
    )  # fmt: skip


def whole_numbers(text: str | None, option: str) -> tuple[int, ...] | None:
    """Numbers between commas."""
    if text is None:
        return None
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError as error:
        raise DoormanError("not whole numbers", field=option, given=text, allowed="such as 1,2,3") from error


def real_numbers(text: str | None, option: str, count: int) -> tuple[float, ...] | None:
    """Numbers between commas."""
    if text is None:
        return None
    with contextlib.suppress(ValueError):
        values = tuple(float(part) for part in text.split(","))
        if len(values) == count and all(map(math.isfinite, values)):
            return values
    raise DoormanError("wrong numbers", field=option, given=text, allowed=f"{count} finite numbers between commas")
