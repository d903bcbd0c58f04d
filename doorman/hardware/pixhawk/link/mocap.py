"""Mocap poses out to the autopilot, each once, stamped with the time at which it was true."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import vector
from doorman.exceptions import DimensionError
from doorman.hardware.pixhawk.wire.frames import LocalFrame
from doorman.hardware.pixhawk.wire.messages import Message, mavlink, seconds_to_us
from doorman.kinematics.quaternions import to_attitude, unit_quaternion

_LARGEST = 1e4
_UNKNOWN_COVARIANCE = (math.nan, *(0.0,) * 20)
"""NaN in the first place: the autopilot's own noise parameters count."""


@dataclass(frozen=True)
class MocapPose:
    time: float  # when it was true, on this computer's monotonic clock [s]
    position: NDArray[np.float64]  # shape (3,), world frame [m]
    quaternion: NDArray[np.float64]  # [w, x, y, z], body to world, shape (4,)

    @classmethod
    def checked(cls, time: float, position: ArrayLike, quaternion: ArrayLike) -> MocapPose:
        place = vector(position, 3, "mocap.position")
        if not math.isfinite(time) or np.abs(place).max() > _LARGEST:
            raise DimensionError("not a pose", field="mocap", given=(time, place.tolist()), allowed="finite numbers")
        return cls(float(time), place, np.array(unit_quaternion(quaternion, "mocap.quaternion")))


@dataclass(frozen=True)
class MocapStatistics:
    """What became of the poses."""

    sent: int = 0
    dropped: int = 0  # too old, from the future, or not newer than the one before
    median_delay: float = math.nan
    """From capture to sending, over the last 200 poses [s]; what the autopilot's delay parameter stands for."""
    max_delay: float = math.nan  # [s]


class MocapOutlet:
    """Latest pose, sent at most at a rate; a pose that was sent, or is too old, is not sent again."""

    def __init__(self, frame: LocalFrame, rate: float, max_age: float) -> None:
        self._frame = frame
        self._period = 1.0 / rate
        self._max_age = max_age
        self._latest: MocapPose | None = None
        self.newest_time = -math.inf
        self._newest_sent = -math.inf
        self._last_sent = -math.inf
        self._delays: deque[float] = deque(maxlen=200)
        self._sent = 0
        self._dropped = 0

    def offer(self, pose: MocapPose, now: float) -> bool:
        """Take a pose to be sent, unless it is old, from the future, or not newer than the last."""
        if pose.time <= self.newest_time or not now - self._max_age <= pose.time <= now + 0.02:
            self._dropped += 1
            return False
        self.newest_time = pose.time
        self._latest = pose
        return True

    def message(self, now: float) -> Message | None:
        """VISION_POSITION_ESTIMATE of a pose that is waiting and due; None if there is none."""
        pose = self._latest
        if pose is None or pose.time <= self._newest_sent or now - self._last_sent < self._period - 1e-3:
            return None
        self._newest_sent = pose.time
        if now - pose.time > self._max_age:
            self._dropped += 1
            return None
        self._last_sent = now
        self._sent += 1
        self._delays.append(max(0.0, now - pose.time))
        position = self._frame.position_to_ned(pose.position)
        attitude = np.array(to_attitude(self._frame.quaternion_to_ned(pose.quaternion).tolist()))
        return mavlink.MAVLink_vision_position_estimate_message(
            seconds_to_us(pose.time), *position.tolist(), *attitude.tolist(), _UNKNOWN_COVARIANCE, 0
        )

    def statistics(self) -> MocapStatistics:
        delays = list(self._delays)
        if not delays:
            return MocapStatistics(self._sent, self._dropped)
        return MocapStatistics(self._sent, self._dropped, float(np.median(delays)), max(delays))
