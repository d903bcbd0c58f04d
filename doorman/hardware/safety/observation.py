"""What the supervisor sees at one time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from doorman.arrays import Array
from doorman.hardware.dynamixel import BusState, ServoFault
from doorman.hardware.mocap import PoseQuality
from doorman.hardware.pixhawk import Authority, EventKind


@dataclass(frozen=True)
class Observation:
    """State of vehicle, links and mission; NaN where something is unknown, which no bound takes for safe or unsafe."""

    now: float
    """By `time.monotonic` [s]."""
    armed: bool = True
    commanding: bool = True
    """Whether the mission is flying: only then must commands come."""
    authority: Authority = Authority.ENGAGED
    conditions: frozenset[EventKind] = frozenset()
    """Conditions of the autopilot's link."""
    position: Array = field(default_factory=lambda: np.full(3, math.nan))
    """Position of O_B, shape (3,), world frame [m]."""
    speed: float = math.nan
    """[m/s]."""
    tilt: float = math.nan
    """[rad]."""
    thrust_share: float = math.nan
    """Commanded thrust over the largest."""
    force: float = math.nan
    """Estimated force of the surroundings on the vehicle [N]."""
    lift: float = math.nan
    """Its share upwards, over the weight."""
    pose: PoseQuality | None = None
    """None where the autopilot's own estimate is flown on."""
    pose_jumped: bool = False
    """Whether there is no usable pose because the cameras saw the vehicle jump."""
    pose_age: float = math.nan
    """Age of a pose as the next one comes, over the oldest that the controller's gains bear."""
    misfit: float = math.nan
    """By how much pose, arm and door do not fit together while the gripper holds, in standard deviations."""
    divergence: float = math.nan
    """Between the cameras' and the autopilot's position [m]."""
    disobedience: float = math.nan
    """Angle by which the autopilot steers elsewhere than commanded, or is on its way to, with the door in the gripper [rad]."""
    grips_unheard: bool = False
    """Whether the gripper holds the door while only the cameras see the vehicle: the autopilot may not hear us either."""
    battery: float = math.nan
    """Share of the charge."""
    servo_fault: ServoFault = ServoFault.NONE
    grip_failed: bool = False
    """Whether the gripper does not hold, or let go, though it should, or its servo has failed while it holds."""
    servo_state: BusState = BusState.FOLLOWING
    command_age: float = 0.0
    """Since the mission's last command [s]."""
    missed_ticks: float = 0.0
    """Share of the controller's ticks that were missed in the last second."""
