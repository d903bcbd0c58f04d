"""How a flight ends, by what cameras, tilt, speeds and forces have shown: it stands, has fallen, or lies on something."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Iterable
from enum import Enum

import numpy as np

from doorman.control.passage import over_the_sill
from doorman.hardware.pixhawk.config import HEARTBEAT
from doorman.hardware.pixhawk.link.stream import LONGEST_BLIND_HOLD
from doorman.hardware.safety import Observation
from doorman.hardware.vehicle.places import LEG_CLEARANCE, LYING
from doorman.model import Model

_UNEVEN = LEG_CLEARANCE / 2
"""Between two places of a level floor, with what cameras err; steps of sills and boxes are higher [m]."""
_ALOFT = 3 * LEG_CLEARANCE
"""Height above where it stood from which on a vehicle has taken off [m]."""
RECENT = LONGEST_BLIND_HOLD
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
        while self._places[0][0] < seen.now - RECENT:
            self._places.popleft()
        if not self._flown:
            self._stood = height
        self._risen = self._risen or height > self._stood + _ALOFT
        self._dropped = self._dropped or (runs and not lands and self._risen and height < self._stood + _UNEVEN)

    @property
    def still(self) -> bool:
        """Whether the cameras see it, and it does not move."""
        places = [place for time, place in tuple(self._places) if time >= self._now - RECENT]
        if len(places) < 2 or self._places[-1][0] - self._places[0][0] < 0.5 * RECENT:
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
        return None if newest is None or newest[0] < now - RECENT else newest[1]


def tells_of_crash(texts: Iterable[str]) -> bool:
    """Whether an autopilot has said that the vehicle crashed."""
    return any(_CRASH.search(text) for text in texts)


FALLING = 2.0
"""No vehicle lands so fast: it has fallen by 0.2 m then [m/s]."""
_REMEMBERED = 2 * HEARTBEAT
"""A heartbeat reports motors that stopped; a fall from 1.3 m takes half a second [s]."""


class FallWatch:
    """Speeds of a vehicle that is, or was, in the air; noted by one thread, and read by another."""

    def __init__(self) -> None:
        self._speeds: deque[tuple[float, float]] = deque()
        self._flown = self._armed = False
        self._flew_at = -math.inf

    def note(self, now: float, speed: float, armed: bool, heard: bool = True) -> None:
        """Take in a look."""
        self._armed, self._flown = armed, self._flown or armed
        if (armed and heard) or not self._flown:
            self._flew_at = now
        self._speeds.append((now, speed))
        while self._speeds[0][0] < self._flew_at - _REMEMBERED:
            self._speeds.popleft()

    @property
    def fell(self) -> bool:
        """Whether it fell when its motors had stopped, or shortly before that was heard."""
        return self._flown and not self._armed and any(speed > FALLING for _, speed in tuple(self._speeds))


_BORNE, _FOR = 0.3, 0.3
"""Share of the weight that something else bears [1]: the friction of a tip that presses lifts less. For so long [s]: a blow at
the first touch passes sooner."""


class CarriedWatch:
    """Lift by the surroundings of a vehicle whose gripper holds nothing."""

    def __init__(self) -> None:
        self._since = math.inf
        self.words = ""  # what bore how much of the vehicle, where it lay and how; empty if nothing did

    def note(self, seen: Observation, holds: bool) -> None:
        """Take in a look, and whether the gripper holds the leaf, which may bear the vehicle."""
        if holds or not seen.lift > _BORNE:
            self._since = math.inf
            return
        self._since = min(self._since, seen.now)
        if seen.now - self._since > _FOR and not self.words:
            x, y, z = seen.position.tolist()
            self.words = (
                f"something bore {seen.lift:.0%} of the vehicle's weight at {x:.2f}, {y:.2f}, {z:.2f} m, "
                f"tilted by {math.degrees(seen.tilt):.0f}°: it lay on sill, frame or floor"
            )


class End(Enum):
    """How a flight ended."""

    NOT_FLOWN = "not flown"
    """It was refused on the ground; the vehicle is disarmed."""
    LANDED = "landed and disarmed"
    FALLEN = "fallen: the motors stopped in the air"
    CRASHED = "crashed: the vehicle lies on its side, or the autopilot reports a crash"
    ON_SILL = "lies in the doorway, on the sill or between the jambs"
    HELD_UP = "lies on something: higher than it stood before the flight"
    DROPPED = "came down before it was commanded to land"
    TAKEN_OVER = "taken over by the pilot or the autopilot"
    """And still armed when the session ended."""
    UNHEARD = "link lost: the autopilot's own failsafe lands the vehicle"
    """The link is gone."""
    STILL_ARMED = "still armed: take the vehicle over by radio"
    """It was commanded to land and does not report that it has."""


BY_REST = {Rest.TILTED: End.CRASHED, Rest.ON_SILL: End.ON_SILL, Rest.HELD_UP: End.HELD_UP, Rest.DROPPED: End.DROPPED}
"""End of a flight whose vehicle is down and does not stand where it should."""
