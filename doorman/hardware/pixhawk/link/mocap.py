"""Mocap poses out to the autopilot, each once, stamped with the time at which it was true."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from statistics import median

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import vector
from doorman.exceptions import DimensionError
from doorman.hardware.pixhawk.sample import LARGEST
from doorman.hardware.pixhawk.wire.frames import LocalFrame
from doorman.hardware.pixhawk.wire.messages import Message, mavlink
from doorman.kinematics.quaternions import to_attitude, unit_quaternion

_UNKNOWN_COVARIANCE = (math.nan, *np.zeros(20))
"""NaN in the first place: the autopilot's own noise parameters count."""


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
        self._frame, self._period, self._max_age = frame, 1.0 / rate, max_age
        self._latest: tuple[float, Array, tuple[float, ...]] | None = None  # time, position, quaternion
        self.newest_time = self._newest_sent = self._last_sent = -math.inf
        self._delays: deque[float] = deque(maxlen=200)
        self._sent = self._dropped = 0

    def offer(self, time: float, position: ArrayLike, quaternion: ArrayLike, now: float) -> bool:
        """Take a pose to be sent, unless it is old, from the future, or not newer than the last."""
        place, turn = vector(position, 3, "mocap.position"), unit_quaternion(quaternion, "mocap.quaternion")
        if not math.isfinite(time) or np.abs(place).max() > LARGEST:
            raise DimensionError("not a pose", field="mocap", given=(time, place.tolist()), allowed="finite numbers")
        if time <= self.newest_time or not now - self._max_age <= time <= now + 0.02:
            self._dropped += 1
            return False
        self.newest_time, self._latest = time, (time, place, turn)
        return True

    def message(self, now: float) -> Message | None:
        """VISION_POSITION_ESTIMATE of a pose that is waiting and due; None if there is none."""
        latest = self._latest  # others offer meanwhile
        if latest is None or latest[0] <= self._newest_sent or now - self._last_sent < self._period - 1e-3:
            return None
        time, place, turn = latest
        self._newest_sent = time
        if now - time > self._max_age:
            self._dropped += 1
            return None
        self._last_sent = now
        self._sent += 1
        self._delays.append(max(0.0, now - time))
        position = self._frame.position_to_ned(place).tolist()
        attitude = to_attitude(self._frame.quaternion_to_ned(turn).tolist())
        return mavlink.MAVLink_vision_position_estimate_message(
            round(1e6 * time), *position, *attitude, _UNKNOWN_COVARIANCE, 0
        )

    def statistics(self) -> MocapStatistics:
        delays = list(self._delays) or [math.nan]
        return MocapStatistics(self._sent, self._dropped, median(delays), max(delays))
