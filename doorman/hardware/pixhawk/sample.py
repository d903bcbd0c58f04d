"""What the autopilot says about the vehicle, at one time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from doorman.arrays import Array, sealed
from doorman.hardware.pixhawk.dialect import Mode
from doorman.hardware.pixhawk.wire.messages import mavlink

LARGEST = 1e4
"""Largest plausible position [m], velocity [m/s], rate [rad/s] or force [N] of a vehicle."""


def unknown(size: int) -> Array:
    """A read-only vector of NaN: nothing has been received yet."""
    return sealed(np.full(size, math.nan))


class SampleStatus(Enum):
    """Whether a sample may be flown on."""

    FRESH = "fresh"
    STALE = "stale"
    """Attitude or position is older than allowed."""
    INCOMPLETE = "incomplete"
    """Attitude or position has not been received since the link was opened or the autopilot rebooted."""


class LandedState(Enum):
    """EXTENDED_SYS_STATE's view; numbers are MAVLink's."""

    UNKNOWN = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4


@dataclass(frozen=True)
class Battery:
    """Battery as reported; NaN is unknown."""

    voltage: float = math.nan
    """[V]"""
    current: float = math.nan
    """[A]"""
    remaining: float = math.nan
    """Share of the charge, 0 … 1."""
    alarm: bool = False
    """Whether the autopilot calls it low or worse."""
    time: float = -math.inf
    """When it was received [s]."""
    id: int | None = None
    """Which one; None where SYS_STATUS tells of all."""


@dataclass(frozen=True)
class VehicleSample:
    """Newest state; times are on this computer's monotonic clock, mapped from the autopilot's stamps."""

    status: SampleStatus = SampleStatus.INCOMPLETE
    """As of the call that returned this sample."""
    attitude_time: float = -math.inf
    """When attitude and body rates were true [s]."""
    position_time: float = -math.inf
    """When position and velocity were true [s]."""
    position: Array = field(default_factory=lambda: unknown(3))
    """Shape (3,), world frame [m]."""
    velocity: Array = field(default_factory=lambda: unknown(3))
    """Shape (3,), world frame [m/s]."""
    attitude: Array = field(default_factory=lambda: unknown(3))
    """[φ, θ, ψ], shape (3,) [rad]."""
    quaternion: Array = field(default_factory=lambda: unknown(4))
    """[w, x, y, z], body to world, shape (4,)."""
    body_rates: Array = field(default_factory=lambda: unknown(3))
    """Shape (3,), body frame [rad/s]."""
    battery: Battery = Battery()
    mode: Mode = Mode(-1, "unknown")
    armed: bool = False
    landed: LandedState = LandedState.UNKNOWN
    system_status: int = 0
    """MAV_STATE of the heartbeat."""
    heartbeat_time: float = -math.inf
    """When the newest heartbeat was received [s]."""
    ready_to_arm: bool | None = None
    """The autopilot's own pre-arm checks; None where it does not report them, as PX4 since 1.14."""
    thrust_target: float = math.nan
    """Normalised thrust that the autopilot commands its mixer, 0 … 1; what hover calibration looks at."""
    attitude_target: Array = field(default_factory=lambda: unknown(3))
    """Φ that the autopilot steers by, shape (3,), world frame [rad]."""
    thrust_target_time: float = -math.inf
    """When both were received [s]."""

    @property
    def terminated(self) -> bool:
        """Whether motors are stopped by a kill switch, or flight termination: armed it still is."""
        return bool(self.system_status == mavlink.MAV_STATE_FLIGHT_TERMINATION)

    def age(self, now: float) -> float:
        """Time since the older of attitude and position was true [s].

        Args:
            now: `time.monotonic()`.

        Returns:
            Infinity while one of them is missing.
        """
        return now - min(self.attitude_time, self.position_time)
