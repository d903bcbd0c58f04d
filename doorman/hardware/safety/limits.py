"""What the supervisor allows."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from doorman.exceptions import BackendError


@dataclass(frozen=True)
class SafetyLimits:
    """Bounds of a flight.

    Raises:
        BackendError: if a value is out of range.
    """

    fence_low: tuple[float, float, float] = (-3.0, -2.5, 0.0)
    """Lowest corner of the box in which O_B may be, world frame [m]."""
    fence_high: tuple[float, float, float] = (3.0, 3.5, 3.0)
    """Highest corner [m]."""
    tilt: float = 0.6
    """Largest angle between the body's z axis and the vertical [rad]."""
    speed: float = 1.5
    """[m/s]."""
    thrust_share: float = 0.95
    """Thrust above this share of the largest counts as saturated."""
    force: float = 18.0
    """Largest force of the surroundings on the vehicle [N]."""
    divergence: float = 0.15
    """Largest distance between the cameras' and the autopilot's position [m]."""
    disobedience: float = 0.2
    """Largest angle between the attitude that the autopilot steers by and the commanded one [rad]."""
    missed_ticks: float = 0.5
    """Largest share of the controller's ticks that may be missed within a second."""
    command_age: float = 0.25
    """Without a command for this long, the controller counts as silent [s]."""
    low_battery: float = 0.2
    """Share of the charge at which the task is given up."""
    critical_battery: float = 0.1
    """Share of the charge at which the vehicle lands where it is."""

    def __post_init__(self) -> None:
        if not (np.asarray(self.fence_low) < np.asarray(self.fence_high)).all():
            raise BackendError("the fence has no inside", field="safety.fence_low", given=self.fence_low,
                               allowed=f"below {self.fence_high}")  # fmt: skip
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, float) and not (math.isfinite(value) and value > 0.0):
                raise BackendError("out of range", field=f"safety.{field.name}", given=value, allowed="a number > 0")
        if self.critical_battery > self.low_battery:
            raise BackendError("out of range", field="safety.critical_battery", given=self.critical_battery,
                               allowed=f"up to low_battery, {self.low_battery:g}")  # fmt: skip
