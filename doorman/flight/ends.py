"""How a flight may end."""

from __future__ import annotations

from enum import Enum

from doorman.flight.watches.rest import Rest


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


BY_REST = {
    Rest.TILTED: End.CRASHED,
    Rest.ON_SILL: End.ON_SILL,
    Rest.HELD_UP: End.HELD_UP,
    Rest.DROPPED: End.DROPPED,
}
"""End of a flight whose vehicle is down and does not stand where it should."""
