"""The emulated autopilot's estimator: its error drifts without aiding, and is pulled in by poses or by satellites."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from doorman.rig.emulators.autopilot.earth import ZURICH, Place
from doorman.rig.emulators.autopilot.plant import GRAVITY, Array, PlantTruth, into_body

_HISTORY = 2.0
_GAIN = 0.35
_GATE = 0.5
"""Innovation that is rejected [m], unless it persists."""
_RESET_AFTER = 1.0
_POSES_NEEDED = 10
_FAR_AWAY = np.array([5.2e6, -1.1e6, 0.0])
"""From where PX4's map begins to a place in Switzerland [m]."""
_DATUM_DELAY = 1.0
"""From the origin to the height's new zero [s]."""
_SAME_ELEVATION = 1.0
"""Of an origin that changes no zero of the height [m]."""


@dataclass(frozen=True)
class Estimate:
    """What the autopilot believes; world frame, body to world."""

    position: Array
    velocity: Array
    quaternion: Array
    body_rates: Array
    position_valid: bool
    on_earth: bool = True
    """Whether it knows where on earth that is, too: what has no home cannot return."""
    origin: Place | None = None
    """Where on earth zero is."""
    specific_force: Array = field(default_factory=lambda: np.array([0.0, 0.0, GRAVITY]))
    """What accelerometers feel, shape (3,), body frame [m/s²]."""


class Estimator:
    """Truth plus an error.

    Args:
        vision: Aided by poses, rather than by satellites.
        timeout: Without aiding, after which the position is invalid [s].
        seed: Of the noise.
        px4: Whether it is PX4's, which navigates without an origin, and moves with one, rather than ArduPilot's.
    """

    def __init__(self, vision: bool, timeout: float, seed: int = 0, *, px4: bool = False) -> None:
        self.vision = vision
        self._px4 = px4
        self.accepted_poses = 0
        self.rejected_poses = 0
        self.last_innovation = 0.0
        """Of the newest accepted pose [m]."""
        self._timeout = timeout
        self._random = np.random.default_rng(seed)
        self._velocity: Array | None = None
        self._error = np.zeros(3)
        self._error_rate = np.zeros(3)
        self._bias = np.array([0.04, -0.03, 0.01])
        self._history: deque[tuple[float, Array]] = deque()
        self._aided_at = float("-inf")
        self._rejected_since: float | None = None
        self.failed = False
        """Whether the position estimate is lost."""
        self._shift, self._datum_due, self._elevation = np.zeros(3), math.inf, 0.0
        self.origin = None if vision else ZURICH
        """Where on earth the zero of its position is; None before it has one."""

    @property
    def has_origin(self) -> bool:
        """Whether it has a place on earth."""
        return self.origin is not None

    @property
    def navigates(self) -> bool:
        """Whether it has what it needs for a position, an origin perhaps excepted."""
        return not self.vision or self.accepted_poses >= _POSES_NEEDED

    def set_origin(self, now: float, armed: bool, place: Place) -> None:
        """Take an origin.

        What ArduPilot believes to be its height soon after becomes zero, unless it is armed or the altitude is not new: poses
        that come go on being fused as they are, and what is told of the height is larger by that from then on. What PX4 tells
        moves by the altitude, and by the way from the equator where it navigates already, as its development version of August
        2026 does.
        """
        self.origin, altitude = place, place.altitude
        if self._px4:
            self._shift = np.array([0.0, 0.0, -altitude]) + (_FAR_AWAY if self.navigates else 0.0)
        else:
            due = not armed and abs(altitude - self._elevation) > _SAME_ELEVATION
            self._datum_due, self._elevation = (now + _DATUM_DELAY, altitude) if due else (math.inf, self._elevation)

    def update(self, now: float, truth: PlantTruth, dt: float) -> Estimate:
        """Estimate at a time of the autopilot's clock [s]."""
        gained = truth.velocity - (truth.velocity if self._velocity is None or dt <= 0.0 else self._velocity)
        self._velocity = truth.velocity
        acceleration = gained / max(dt, 1e-3) + [0.0, 0.0, GRAVITY]
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
            self._shift[2] = float(truth.position[2] + self._error[2]) if self.accepted_poses > 0 else 0.0
        located = self.has_origin or self._px4
        valid = self.navigates and now - self._aided_at < self._timeout and not self.failed and located
        return Estimate(
            truth.position + self._error + self._shift,
            truth.velocity + self._error_rate,
            truth.quaternion,
            truth.body_rates,
            valid,
            valid and self.has_origin,
            self.origin,
            into_body(truth.quaternion, acceleration),
        )

    def lead_astray(self, offset: Array) -> None:
        """Be wrong by this much more from now on [m], shape (3,), world frame, until poses put it right."""
        self._error = self._error + offset

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
        if self.navigates and size > _GATE:
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
