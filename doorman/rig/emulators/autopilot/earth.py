"""Where on earth the emulated autopilot believes to be: its origin, and the messages that tell of latitude and longitude."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.plant import Array

_EARTH_RADIUS = 6_371_000.0
_UNKNOWN = 0xFFFF


@dataclass(frozen=True)
class Place:
    """A place on earth."""

    latitude: float
    """[°]."""
    longitude: float
    """[°]."""
    altitude: float
    """Above mean sea level [m]."""

    def displaced(self, position: Array) -> Place:
        """The place of a position with x to the north and y to the west, shape (3,) [m], as a flat earth has it."""
        north, west, up = position.tolist()
        east_per_degree = math.radians(_EARTH_RADIUS * math.cos(math.radians(self.latitude)))
        return Place(
            self.latitude + north / math.radians(_EARTH_RADIUS), self.longitude - west / east_per_degree,
            self.altitude + up,
        )  # fmt: skip

    @property
    def scaled(self) -> tuple[int, int, int]:
        """Latitude and longitude [1e-7 °], altitude [mm]."""
        return _fit(1e7 * self.latitude), _fit(1e7 * self.longitude), _fit(1e3 * self.altitude)


ZURICH = Place(47.397742, 8.545594, 488.0)
"""Where the simulators of PX4 begin, and an emulated one with satellites."""


def global_origin(origin: Place) -> Any:
    """GPS_GLOBAL_ORIGIN."""
    return mavlink.MAVLink_gps_global_origin_message(*origin.scaled)


def global_position(boot_ms: int, origin: Place, position: Array, velocity: Array, yaw: float, home: Array) -> Any:
    """GLOBAL_POSITION_INT.

    Args:
        boot_ms: Time of the autopilot's clock [ms].
        origin: Of the local frame.
        position: Shape (3,), world frame [m].
        velocity: Shape (3,), world frame [m/s].
        yaw: World frame [rad].
        home: Shape (3,), world frame [m].
    """
    north, west, up = (100.0 * velocity).tolist()
    return mavlink.MAVLink_global_position_int_message(
        boot_ms, *origin.displaced(position).scaled, _fit(1e3 * float(position[2] - home[2])),
        _fit(north, 16), _fit(-west, 16), _fit(-up, 16), _heading(yaw),
    )  # fmt: skip


def home_position(boot_ms: int, origin: Place, home: Array, yaw: float) -> Any:
    """HOME_POSITION of a home, shape (3,), world frame [m], with a heading there [rad]."""
    north, west, up = home.tolist()
    q = [math.cos(0.5 * yaw), 0.0, 0.0, -math.sin(0.5 * yaw)]
    unknown = [math.nan] * 3
    return mavlink.MAVLink_home_position_message(
        *origin.displaced(home).scaled, north, -west, -up, q, *unknown, 1000 * boot_ms
    )


def satellites(boot_ms: int, origin: Place, position: Array) -> Any:
    """GPS_RAW_INT of a good receiver at a position, shape (3,), world frame [m]."""
    return mavlink.MAVLink_gps_raw_int_message(
        1000 * boot_ms, mavlink.GPS_FIX_TYPE_3D_FIX, *origin.displaced(position).scaled, 80, 120, _UNKNOWN, _UNKNOWN, 14
    )


def _heading(yaw: float) -> int:
    """Clockwise from north [0.01 °]."""
    return round(100.0 * math.degrees(-yaw)) % 36000


def _fit(value: float, bits: int = 32) -> int:
    """The nearest integer of a signed type."""
    limit = 1 << (bits - 1)
    return max(-limit, min(limit - 1, round(value)))
