"""Overrides of scenario keys on the command line: `--set planner.margin=0.01`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from doorman.bounds import parse_toml
from doorman.exceptions import ScenarioError

_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")
_WORD = re.compile(r"[A-Za-z_./~][^\"'\[\]{}=#,\x00-\x1f\x7f]*|\d{1,3}(\.\d{1,3}){3}")
"""What may stand without quotes: a name, a path or an IPv4 address."""


def parse_overrides(settings: Iterable[str], option: str = "--set") -> dict[str, Any]:
    """Values by dotted key from `key=value` texts; the last of a key wins."""
    return dict(_parse(text, option) for text in settings)


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
