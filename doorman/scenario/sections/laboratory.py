"""The laboratory: where the vehicle may be, and when the supervisor steps in."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from doorman.scenario.values import Number, Positive, Section

_Share = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1)]
_Corner = tuple[Number, Number, Number]


class SafetySection(Section):
    """Bounds of a flight on a vehicle; simulated flights have no supervisor."""

    fence: tuple[_Corner, _Corner] = ((-3.0, -2.5, 0.0), (3.0, 3.5, 3.0))
    """Lowest and highest corner of the box in which O_B may be, world frame [m]."""
    tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=math.pi)] = 0.6
    """Largest angle between the body's z axis and the vertical [rad]."""
    speed: Positive = 1.5
    """Largest speed [m/s]."""
    thrust_share: ClassVar = 0.95
    """Thrust above this share of the largest counts as saturated."""
    force: Positive = 18.0
    """Largest force of the surroundings on the vehicle [N]."""
    pose_age: ClassVar = 1.0
    """Largest age of the poses as the next one comes, over the oldest that the controller's gains bear."""
    misfit: ClassVar = 3.0
    """Largest misfit of the held tip with its way about the hinge, in standard deviations: of the angle that the tip
    measures, and of the hinge's place."""
    divergence: Positive = 0.15
    """Largest distance between the cameras' and the autopilot's position [m]."""
    disobedience: ClassVar = 0.2
    """Largest angle between the attitude that the autopilot steers by and the commanded one, or one on the way to it,
    while the gripper holds the door [rad]."""
    missed_ticks: ClassVar = 0.5
    """Largest share of the controller's ticks that may be missed within a second."""
    command_age: ClassVar = 0.25
    """Without a command for this long, the controller counts as silent [s]."""
    low_battery: _Share = 0.2
    """Share of the charge at which the mission is given up."""

    @model_validator(mode="after")
    def _fits_together(self) -> SafetySection:
        if not all(low < high for low, high in zip(*self.fence, strict=True)):
            raise ValueError("a first corner of safety.fence that is below the second in every coordinate")
        return self

    @property
    def critical_battery(self) -> float:
        """Share of the charge at which the vehicle flies out and lands: half of that at which the mission is given up."""
        return 0.5 * self.low_battery
