"""Tells a landing from a crash: by how the vehicle lies once its motors have stopped, and by what the autopilot says of it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

LYING = math.radians(20.0)
"""No vehicle stands so tilted on its legs [rad]."""
_CRASH = re.compile(r"\bcrash(?:ed|:| detected)", re.IGNORECASE)
"""ArduPilot says `Crash: Disarming: ...`, PX4 `Crash detected`."""


class RestWatch:
    """Tilt of a vehicle that has flown, noted by one thread and asked for by another."""

    def __init__(self) -> None:
        self._flown = self._armed = False
        self._tilt = math.nan

    def note(self, tilt: float, armed: bool) -> None:
        """Take in a look."""
        self._armed, self._flown = armed, self._flown or armed
        if not math.isnan(tilt):
            self._tilt = tilt

    @property
    def lies(self) -> bool:
        """Whether its motors have stopped and it does not stand on its legs."""
        return self._flown and not self._armed and self._tilt > LYING


def tells_of_crash(texts: Iterable[str]) -> bool:
    """Whether an autopilot has said that the vehicle crashed."""
    return any(_CRASH.search(text) for text in texts)
