"""A simulated sensor of the door: what it measures, how often, how late, how well, and what may go wrong with it."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import Field

from doorman.scenario.values import NonNegative, Positive, Section, Switch

Kind = Literal["none", "cameras", "tags", "encoder", "pictures"]
Fault = Literal["none", "freeze", "jump", "late", "upside_down", "wrong_object", "dies"]
_Late = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]


class Usual(NamedTuple):
    """Defaults of one kind of sensor."""

    rate: float
    latency: float
    place: float
    turn: float


USUAL: dict[str, Usual] = {
    "cameras": Usual(100.0, 0.02, 0.001, 0.005),
    "tags": Usual(30.0, 0.06, 0.002, 0.008),
    "encoder": Usual(250.0, 0.004, 0.001, 0.005),
    "pictures": Usual(30.0, 0.06, 0.002, 0.008),
}
"""Rate [1/s], latency [s], and noise of a mark's place [m] and attitude [rad]; of tags as measured on pictures."""


class DoorSensorSection(Section):
    """Simulated sensor of the door."""

    kind: Kind = "none"
    """`"cameras"` see marks on leaf and frame; `"tags"`, by the accuracy of a camera on the vehicle; an `"encoder"` of the
    joint; or `"pictures"` that MuJoCo renders, for the real detector (extra `tags`)."""
    frame: Switch = True
    """Whether the frame is measured, too; never by an encoder."""
    rate: Positive | None = None
    """Readings per second [1/s]. Default: cameras 100, tags 30, an encoder 250."""
    latency: _Late | None = None
    """Time after which a reading comes; up to 1 [s]. Default: cameras 0.02, tags 0.06, an encoder 0.004."""
    place_noise: NonNegative | None = None
    """Standard deviation of a mark's place; that of its attitude, and of an encoder's angle, goes with it: 5 rad/m, of tags
    4 rad/m [m]. Default: cameras 0.001, tags 0.002."""
    dropout_rate: NonNegative = 0.0
    """Gaps without a reading, per second without a gap [1/s]."""
    dropout_duration: NonNegative = 0.2
    """Longest gap; gaps are evenly spread from 0 to it [s]."""
    field_of_view: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=math.pi)] = math.radians(70.0)
    """Vertical angle that the camera on the vehicle sees, on pictures of 640 by 480; up to π [rad]."""
    tag_size: ClassVar = 0.16
    """Edge of a tag's black square [m]."""
    fault: Fault = "none"
    """What goes wrong: the readings freeze, jump by 10°, come 300 ms late with a stamp of now, count backwards, are those
    of another object, or end."""
    fault_opening: NonNegative = 0.0
    """Opening of the leaf from which on it does [rad, or m]."""

    @property
    def works(self) -> bool:
        """Whether there is one."""
        return self.kind != "none"

    @property
    def usual(self) -> Usual:
        """Rate, latency and noise as given, or as usual for the kind."""
        usual, given = USUAL[self.kind], (self.rate, self.latency, self.place_noise)
        rate, latency, place = (
            default if value is None else value for value, default in zip(given, usual, strict=False)
        )
        return Usual(rate, latency, place, usual.turn * place / usual.place)
