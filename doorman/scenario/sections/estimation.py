"""What an estimate goes by: how well door, poses and sensors are known, and numbers of the filter at the leaf."""

from __future__ import annotations

import math
from typing import ClassVar

from doorman.scenario.values import NonNegative, Positive, Section

USUAL_HINGE = {"damping": (0.7, 0.7), "friction": (0.8, 0.6), "stiffness": (0.5, 0.7)}
"""Mean and deviation of what a room door's hinge resists with, where nobody says: damping [N m s/rad], friction [N m], and
stiffness of a closer [N m/rad]."""


_APART = 0.8
"""Between the two places by which a doorway's heading is measured, on either jamb [m]."""


class NoiseNumbers(Section):
    """What changes slowly, or by what is not in the model: deviations after one second."""

    wind: Positive = 0.03
    """Mean wind [N/s^½]."""


class EstimationSection(Section):
    """How well door, frame of the poses and force sensor are known, and from when on the mission believes what it estimates."""

    sure: ClassVar = 0.8
    """Probability from which on the mission believes that the tip touches the leaf, or has left it."""
    loose_time: ClassVar = 0.12
    """Time for which a closed gripper must probably hold nothing, before it does not hold the leaf [s]."""
    slam_speed: ClassVar = 0.4
    """Speed with which a leaf throws a tip back that touches it, from which on it is slammed [m/s]."""
    gate: ClassVar = 8.0
    """Deviations beyond which a reading is refused: it is of something else, or what it reads is elsewhere."""
    elsewhere: ClassVar = 1.5
    """Deviations of the leaf's place by which a tip that touches nothing is behind it, before the leaf is elsewhere."""
    seen_time: ClassVar = 0.3
    """Time after a reading of the leaf for which it is where it was seen [s]."""
    blow_time: ClassVar = 0.1
    """Time for which poses may be refused; then the vehicle has had a blow, and the filter begins anew [s]."""
    swap_time: ClassVar = 1.0
    """Time for which cameras may take markers for others; then the frame of the poses has moved [s]."""

    door_place_deviation: NonNegative = 0.015
    """Standard deviation of the hinge's place from the URDF's, along either horizontal axis; that of the doorway's heading
    goes with it: 1.7 rad/m. With 0, the map is trusted [m]."""
    frame_walk: NonNegative = 0.0
    """Standard deviation by which the frame of the poses walks in a second, along either horizontal axis; it grows with
    the root of the time [m/s^½]."""
    frame_touch: ClassVar = 0.003
    """Standard deviation of a touch of the frame: poses, and how flat a wall is [m]."""
    frame_track: ClassVar = 0.002
    """Standard deviation of a gripping tip's track about the hinge, over 0.1 s [m]."""
    tip_force_noise: ClassVar = 0.05
    """Standard deviation of the white noise of a force sensor in the tip, where there is one [N]."""
    tip_force_offset: ClassVar = 0.2
    """Standard deviation of that sensor's offset, until the readings of free flight tell it [N]."""

    noise: NoiseNumbers = NoiseNumbers()

    @property
    def door_yaw_deviation(self) -> float:
        """Standard deviation of the doorway's heading [rad]: of a line between two places so well known."""
        return math.sqrt(2.0) * self.door_place_deviation / _APART
