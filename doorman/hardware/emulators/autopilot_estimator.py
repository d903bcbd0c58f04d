"""The emulated autopilot's estimator: its error drifts without aiding, and is pulled in by poses or by satellites."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from doorman.hardware.emulators.autopilot_plant import Array, PlantTruth

_HISTORY = 2.0
_GAIN = 0.35
_GATE = 0.5
"""Innovation that is rejected [m], unless it persists."""
_RESET_AFTER = 1.0
_POSES_NEEDED = 10
_DATUM_DELAY = 1.0
"""From the origin to the height's new zero [s]."""


@dataclass(frozen=True)
class Estimate:
    """What the autopilot believes; world frame, body to world."""

    position: Array
    velocity: Array
    quaternion: Array
    body_rates: Array
    position_valid: bool


class Estimator:
    """Truth plus an error.

    Args:
        vision: Aided by poses, rather than by satellites.
        timeout: Without aiding, after which the position is invalid [s].
        seed: Of the noise.
    """

    def __init__(self, vision: bool, timeout: float, seed: int = 0) -> None:
        self.vision = vision
        self.accepted_poses = 0
        self.rejected_poses = 0
        self.last_innovation = 0.0
        """Of the newest accepted pose [m]."""
        self._timeout = timeout
        self._random = np.random.default_rng(seed)
        self._error = np.zeros(3)
        self._error_rate = np.zeros(3)
        self._bias = np.array([0.04, -0.03, 0.01])
        self._history: deque[tuple[float, Array]] = deque()
        self._aided_at = float("-inf")
        self._rejected_since: float | None = None
        self.failed = False
        """Whether the position estimate is lost."""
        self._datum, self._datum_due = 0.0, math.inf
        self.has_origin = True

    def require_origin(self) -> None:
        """Have no position before an origin is given."""
        self.has_origin = False

    def set_origin(self, now: float, armed: bool) -> None:
        """Take an origin; disarmed, what is believed to be the height soon after becomes zero, as ArduPilot has it.

        Poses that come go on being fused as they are; what is told of the height is larger by that from then on.
        """
        self.has_origin = True
        self._datum_due = math.inf if armed else now + _DATUM_DELAY

    def update(self, now: float, truth: PlantTruth, dt: float) -> Estimate:
        """Estimate at a time of the autopilot's clock [s]."""
        self._history.append((now, truth.position))
        while now - self._history[0][0] > _HISTORY:
            self._history.popleft()
        if not self.vision:
            self._error = self._random.normal(0.0, 0.002, 3)
            self._error_rate = np.zeros(3)
            self._aided_at = now
        elif now - self._aided_at > 0.2:
            self._error_rate = self._error_rate + dt * self._bias
            self._error = self._error + dt * self._error_rate
        if now >= self._datum_due:
            self._datum_due = math.inf
            self._datum = float(truth.position[2] + self._error[2]) if self.accepted_poses > 0 else 0.0
        enough = not self.vision or self.accepted_poses >= _POSES_NEEDED
        valid = enough and now - self._aided_at < self._timeout and not self.failed and self.has_origin
        return Estimate(
            truth.position + self._error + np.array([0.0, 0.0, self._datum]),
            truth.velocity + self._error_rate,
            truth.quaternion,
            truth.body_rates,
            valid,
        )

    def pose(self, now: float, stamp: float, position: Array) -> None:
        """Fuse a pose that was true at a time of the autopilot's clock [s]."""
        if not self.vision or not self._history:
            return
        times = [time for time, _ in self._history]
        places = np.array([place for _, place in self._history])
        if not times[0] <= stamp <= now + 0.05:
            self.rejected_poses += 1
            return
        truth = np.array([np.interp(stamp, times, places[:, axis]) for axis in range(3)])
        innovation = (position - truth) - self._error
        size = float(np.linalg.norm(innovation))
        if self.accepted_poses >= _POSES_NEEDED and size > _GATE:
            self.rejected_poses += 1
            self._rejected_since = now if self._rejected_since is None else self._rejected_since
            if now - self._rejected_since < _RESET_AFTER:
                return
            self._error = position - truth
        else:
            self._error = self._error + _GAIN * innovation
        self._error_rate = 0.5 * self._error_rate
        self._rejected_since = None
        self.accepted_poses += 1
        self.last_innovation = size
        self._aided_at = now
