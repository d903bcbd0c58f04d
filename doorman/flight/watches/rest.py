"""How a vehicle lies once it is down, by cameras and tilt: the one judgement behind every final word of a flight."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Iterable
from enum import Enum

import numpy as np

from doorman.control.passage import over_the_sill
from doorman.hardware.safety import Observation
from doorman.hardware.vehicle.places import LEG_CLEARANCE
from doorman.model import Model

LYING = math.radians(20.0)
"""No vehicle stands so tilted on its legs [rad]."""
_UNEVEN = 0.5 * LEG_CLEARANCE
"""Between two places of a level floor, with what cameras err; steps of sills and boxes are higher [m]."""
_ALOFT = 3.0 * LEG_CLEARANCE
"""Height above where it stood from which on a vehicle has taken off [m]."""
_RECENT = 1.0
"""A place that was seen so long ago is not where the vehicle is now; for so long one that is still has not moved [s]."""
_STILL = 0.03
"""Way within that time of a vehicle that lies still [m]."""
_CRASH = re.compile(r"\bcrash(?:ed|:| detected)", re.IGNORECASE)
"""ArduPilot says `Crash: Disarming: ...`, PX4 `Crash detected`."""


class Rest(Enum):
    """How it lies."""

    UNSEEN = "the vehicle is not seen"
    STANDS = "it stands on the floor"
    TILTED = "it does not stand on its legs"
    ON_SILL = "it lies in the doorway"
    HELD_UP = "it lies higher than it stood before"
    DROPPED = "it came down before it was to land"


class RestWatch:
    """Place and tilt of a vehicle that flies, noted by one thread and read by another; a clock tells that looks are old."""

    def __init__(self, model: Model, clock: Callable[[], float] | None = None) -> None:
        self._model, self._clock = model, clock
        self._stood = math.nan
        self._flown = self._risen = self._dropped = False
        self._tilt, self._now = math.nan, -math.inf
        self._places: deque[tuple[float, np.ndarray]] = deque()

    def note(self, seen: Observation, runs: bool, lands: bool) -> None:
        """Take in a look; whether the motors run, and whether the vehicle is to come down or out of our hands."""
        self._now, self._flown = seen.now, self._flown or runs
        if math.isfinite(seen.tilt):
            self._tilt = seen.tilt
        doubtful = seen.divergence > self._model.scenario.safety.divergence
        if seen.pose is None or not seen.pose.usable or doubtful or not np.isfinite(seen.position).all():
            return
        height = float(seen.position[2])
        self._places.append((seen.now, seen.position.copy()))
        while self._places[0][0] < seen.now - _RECENT:
            self._places.popleft()
        if not self._flown:
            self._stood = height
        self._risen = self._risen or height > self._stood + _ALOFT
        self._dropped = self._dropped or (runs and not lands and self._risen and height < self._stood + _UNEVEN)

    @property
    def still(self) -> bool:
        """Whether the cameras see it, and it does not move."""
        places = [place for time, place in tuple(self._places) if time >= self._now - _RECENT]
        if len(places) < 2 or self._places[-1][0] - self._places[0][0] < 0.5 * _RECENT:
            return False
        return float(np.ptp(np.array(places), axis=0).max()) < _STILL

    @property
    def judged(self) -> Rest:
        """How it lies, once it is down; by its tilt alone where no camera sees it, or the autopilot is sure to be elsewhere."""
        if self._flown and self._tilt > LYING:
            return Rest.TILTED
        place = self._place
        if not self._flown or place is None:
            return Rest.UNSEEN
        if over_the_sill(self._model, place):
            return Rest.ON_SILL
        if float(place[2]) > self._stood + _UNEVEN:
            return Rest.HELD_UP
        return Rest.DROPPED if self._dropped else Rest.STANDS

    @property
    def words(self) -> str:
        """Where and how it was seen last; empty for one that stands where it should, or is not seen."""
        rest, place = self.judged, self._place
        if rest in (Rest.STANDS, Rest.UNSEEN) or place is None:
            return ""
        x, y, z = place.tolist()
        tilt = f", tilted by {math.degrees(self._tilt):.0f}°" if math.isfinite(self._tilt) else ""
        stood = f"; it stood {self._stood:.2f} m high" if math.isfinite(self._stood) else ""
        return f"{rest.value}: at {x:.2f}, {y:.2f}, {z:.2f} m{tilt}{stood}"

    @property
    def _place(self) -> np.ndarray | None:
        """The newest; None where the cameras have not seen the vehicle for a while, or nothing has looked."""
        newest, now = self._places[-1] if self._places else None, self._clock() if self._clock else self._now
        return None if newest is None or newest[0] < now - _RECENT else newest[1]


def tells_of_crash(texts: Iterable[str]) -> bool:
    """Whether an autopilot has said that the vehicle crashed."""
    return any(_CRASH.search(text) for text in texts)
