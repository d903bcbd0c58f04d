"""A simulated sensor of the door: what it measures, how often, how late, how well, and what may go wrong with it."""

from __future__ import annotations

import math
from typing import ClassVar, Literal, NamedTuple

from doorman.scenario.values import NonNegative, Section

Kind = Literal["none", "cameras", "tags", "encoder", "pictures"]
Fault = Literal["none", "freeze", "jump", "late", "upside_down", "wrong_object", "dies"]


class Usual(NamedTuple):
    """What one kind of sensor measures with."""

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
    joint; or `"pictures"` that MuJoCo renders, for the real detector (extra `tags`). Readings of cameras come 100 times a second,
    20 ms late, with 1 mm of noise; those of tags 30 times, 60 ms late, with 2 mm; those of an encoder 250 times, 4 ms late."""
    field_of_view: ClassVar = math.radians(70.0)
    """Vertical angle that the camera on the vehicle sees, on pictures of 640 by 480 [rad]."""
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
        """Rate, latency and noise of the kind."""
        return USUAL[self.kind]
