"""The laboratory: where the vehicle may be, when the supervisor steps in, and how well the place of the door is known."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, model_validator

from doorman.scenario.values import NonNegative, Number, Positive, Section

_Share = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1)]
_Corner = tuple[Number, Number, Number]


class EstimationSection(Section):
    """How well door, frame of the poses and force sensor are known, and from when on the mission believes what it estimates."""

    sure: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0.5, lt=1)] = 0.8
    """Probability from which on the mission believes that the tip touches the leaf, or has left it."""
    loose_time: NonNegative = 0.12
    """Time for which a closed gripper must probably hold nothing, before it does not hold the leaf [s]."""
    slam_speed: Positive = 0.4
    """Speed with which a leaf throws a tip back that touches it, from which on it is slammed [m/s]."""

    door_place_deviation: NonNegative = 0.015
    """Standard deviation of the hinge's place from the URDF's, along either horizontal axis; with `door_yaw_deviation`
    0 as well, the map is trusted [m]."""
    door_yaw_deviation: NonNegative = 0.026
    """Standard deviation of the doorway's heading [rad]."""
    frame_walk: NonNegative = 0.0
    """Standard deviation by which the frame of the poses walks in a second, along either horizontal axis; it grows with
    the root of the time [m/s^½]."""
    tip_force_noise: Positive = 0.05
    """Standard deviation of the white noise of a force sensor in the tip, where there is one [N]."""
    tip_force_offset: NonNegative = 0.2
    """Standard deviation of that sensor's offset, until the readings of free flight tell it [N]."""


class SafetySection(Section):
    """Bounds of a flight on a vehicle; simulated flights have no supervisor."""

    fence_low: _Corner = (-3.0, -2.5, 0.0)
    """Lowest corner of the box in which O_B may be, world frame [m]."""
    fence_high: _Corner = (3.0, 3.5, 3.0)
    """Highest corner of that box [m]."""
    tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=math.pi)] = 0.6
    """Largest angle between the body's z axis and the vertical [rad]."""
    speed: Positive = 1.5
    """Largest speed [m/s]."""
    thrust_share: Positive = 0.95
    """Thrust above this share of the largest counts as saturated."""
    force: Positive = 18.0
    """Largest force of the surroundings on the vehicle [N]."""
    pose_age: Positive = 1.0
    """Largest age of the poses as the next one comes, over the oldest that the controller's gains bear."""
    misfit: Positive = 3.0
    """Largest misfit of the held tip with its way about the hinge, in standard deviations: of the angle that the tip
    measures, and of the hinge's place."""
    divergence: Positive = 0.15
    """Largest distance between the cameras' and the autopilot's position [m]."""
    disobedience: Positive = 0.2
    """Largest angle between the attitude that the autopilot steers by and the commanded one, or one on the way to it,
    while the gripper holds the door [rad]."""
    missed_ticks: Positive = 0.5
    """Largest share of the controller's ticks that may be missed within a second."""
    command_age: Positive = 0.25
    """Without a command for this long, the controller counts as silent [s]."""
    low_battery: _Share = 0.2
    """Share of the charge at which the mission is given up."""
    critical_battery: _Share = 0.1
    """Share of the charge at which the vehicle flies out and lands; up to `low_battery`."""

    @model_validator(mode="after")
    def _fits_together(self) -> SafetySection:
        if not all(low < high for low, high in zip(self.fence_low, self.fence_high, strict=True)):
            raise ValueError("fence_low below fence_high in every coordinate")
        if self.critical_battery > self.low_battery:
            raise ValueError("critical_battery up to low_battery")
        return self
