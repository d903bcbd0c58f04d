"""A force sensor in the tip, such as a load cell: a callable reads it, and what it says is checked here."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from doorman.background import EventLog


class TipReading(NamedTuple):
    """One reading."""

    force: float
    """Force with which the tip presses along the face's normal [N]."""
    time: float
    """When that was true, by `time.monotonic` [s]."""


TipForceSource = Callable[[], TipReading | None]
"""Returns the newest reading at once, or None; called by the thread of the controller, at every tick."""


class TipForce:
    """Readings that can be used, and events that tell when there are none."""

    def __init__(self, source: TipForceSource, stale_after: float) -> None:
        self._source, self._stale_after = source, stale_after  # an older reading counts as none [s]
        self._events = EventLog[tuple[float, str]]()
        self._fault = ""

    def read(self, now: float) -> float | None:
        force, fault = math.nan, ""
        try:
            reading = self._source()
        except Exception as error:  # whatever it is: the vehicle flies without the sensor
            fault = f"{type(error).__name__}: {error}"
        else:
            if reading is None:
                fault = "no reading"
            elif not math.isfinite(reading.force):
                fault = f"the reading is {reading.force:g}"
            elif not abs(now - reading.time) <= self._stale_after:
                fault = "the reading is old"
            else:
                force = float(reading.force)
        if fault != self._fault:
            self._events.write((now, fault or "readings are usable"))
            self._fault = fault
        return None if fault else force

    def events(self) -> list[tuple[float, str]]:
        """Time by `time.monotonic` and words of every change since the last call."""
        return self._events.take()
