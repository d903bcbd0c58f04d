"""Settings of the adapter: cameras, object, frames and the vehicle's motion."""

from __future__ import annotations

from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Annotated

from numpy.typing import ArrayLike

from doorman.checks import Positive, Range, check_fields, check_rules
from doorman.hardware.mocap.connection import parse_connection
from doorman.hardware.mocap.frames import Alignment
from doorman.hardware.mocap.packets import NAME_SIZE


@dataclass(frozen=True)
class MocapConfig:
    """A tracked object and the cameras that see it.

    Raises:
        BackendError: if a value is out of range.
        DimensionError: if an array is not three finite numbers.
    """

    object_name: str
    """Name of the tracked object, as in Tracker."""
    connection: str = "udp:51001"
    """`udp:[HOST:]PORT`: where Tracker's stream is received; loopback unless a host is written. `KIND:HOST[:PORT]`: cameras that
    the extra `mocap` speaks to, see `parse_cameras`."""
    sender: str | None = None
    """IPv4 address of the computer with Tracker; by default the first that sends the object."""
    rate: Annotated[float, Range(10.0, 2000.0, "1/s")] = 100.0
    """Frames per second, as Tracker numbers them [1/s]."""
    latency: Annotated[float, Range(0.0, 0.5, "s")] = 0.005
    """Between exposure and arrival of the quickest packets, which the stream does not contain [s]."""
    origin_position: ArrayLike = (0.0, 0.0, 0.0)
    """Vicon's origin, shape (3,), world frame [m]."""
    origin_attitude: ArrayLike = (0.0, 0.0, 0.0)
    """Attitude Φ of Vicon's axes in the world, shape (3,) [rad]."""
    object_position: ArrayLike = (0.0, 0.0, 0.0)
    """Origin of the tracked object, shape (3,), body frame [m]."""
    object_attitude: ArrayLike = (0.0, 0.0, 0.0)
    """Attitude Φ of the tracked object in the body, shape (3,) [rad]."""
    stale_after: Positive = 0.03
    """Age up to which a pose is fresh [s]."""
    prediction_limit: Positive = 0.1
    """Age up to which a pose is predicted; older ones are lost [s]."""
    silent_after: Positive = 0.2
    """Without a packet for this long, the stream is silent [s]."""
    max_delay: Positive = 0.02
    """A pose that arrives later than this after its time is reported [s]."""
    velocity_window: Positive = 0.05
    """Poses of this time give the velocity, which lags by half of it [s]."""
    max_speed: Positive = 5.0
    """Largest speed of the vehicle [m/s]."""
    max_acceleration: Positive = 20.0
    """Largest acceleration of the vehicle [m/s²]."""
    max_rotation_rate: Positive = 8.0
    """Largest body rate of the vehicle [rad/s]."""
    position_slack: Positive = 0.005
    """What noise and vibration add to a step of the position [m]."""
    attitude_slack: Positive = 0.05
    """What noise and vibration add to a step of the attitude [rad]."""
    acquire_frames: Annotated[int, Range(3)] = 5
    """Poses in a row that agree, before the object is taken as found."""
    missing_frames: Annotated[int, Range(1)] = 3
    """Frames in a row without the object that are reported as missing."""
    open_timeout: Positive = 5.0
    """`open` gives up after this [s]."""
    hold: Positive = 0.5
    """A fault of single packets is reported as ended after this time without another [s]."""

    def __post_init__(self) -> None:
        parse_connection(self.connection)
        self.alignment()
        check_fields(self, "mocap.")
        least, size = self.latency + self.period, len(self.object_name.encode())
        check_rules(
            self, "mocap.",
            (0 < size <= NAME_SIZE and "\0" not in self.object_name, "object_name", "1 to 24 bytes"),
            (self.sender is None or _is_address(self.sender), "sender", "an IPv4 address"),
            (self.stale_after > least, "stale_after", f"above {least:g} s, latency and period"),
            (self.prediction_limit >= self.stale_after, "prediction_limit", ">= stale_after"),
            (self.velocity_window >= 2.0 * self.period, "velocity_window", "two periods at least"),
            (self.silent_after > self.period, "silent_after", "above a period"),
        )  # fmt: skip

    @property
    def period(self) -> float:
        """Period of a frame [s]."""
        return 1.0 / self.rate

    def alignment(self) -> Alignment:
        """Frames of these settings."""
        return Alignment(self.origin_position, self.origin_attitude, self.object_position, self.object_attitude)


def _is_address(text: str) -> bool:
    try:
        return bool(IPv4Address(text).packed)
    except ValueError:
        return False
