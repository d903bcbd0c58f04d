"""Lists of numbers on the command line."""

from __future__ import annotations

import contextlib
import math

from doorman.exceptions import DoormanError


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
