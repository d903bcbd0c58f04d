"""What the emulated autopilot flies, and what it believes of it: its error drifts without aiding by poses or satellites."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from doorman.arrays import Array
from doorman.gravity import weight_of
from doorman.kinematics.quaternions import conjugate, multiply, rotate, to_attitude

FLIP = np.array([1, -1, -1])
"""NED or FRD of a world with z up or a body with z up, and back: half a turn about x."""
FLIP_QUATERNION = np.array([1, 1, -1, -1])
"""FRD to NED of body to world, and back."""
LEVEL, NOTHING = np.eye(4)[0], np.zeros(3)
for _constant in (FLIP, FLIP_QUATERNION, LEVEL, NOTHING):
    _constant.flags.writeable = False


@dataclass(frozen=True)
class PlantTruth:
    position: Array  # shape (3,), world frame, z up [m]
    velocity: Array  # shape (3,), world frame [m/s]
    quaternion: Array  # [w, x, y, z], body (x forward, y left, z up) to world, shape (4,)
    body_rates: Array  # shape (3,), body frame [rad/s]
    on_ground: bool


class AutopilotPlant(Protocol):
    """A vehicle with its attitude loop; the emulated autopilot gives thrust and attitude, as its mixer would."""

    # The emulated autopilot's thread calls all of it; who shares the plant with others must see to their taking turns.

    @property
    def weight(self) -> float:
        """Weight [N]."""

    def command(self, thrust: float, quaternion: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        """Fly with a thrust, and a force to the side, towards an attitude, until the next command."""

    def stop_motors(self) -> None:
        """Let the motors stand still, until the next command."""

    def advance(self, duration: float) -> None:
        """Let time pass; does nothing if somebody else advances the plant."""

    def truth(self) -> PlantTruth:
        """The vehicle as it is now."""


class SimplePlant:
    """A point mass whose attitude follows its setpoint with lags, on flat ground."""

    def __init__(self, mass: float = 3.0, ground: float = 0.0) -> None:
        self.mass, self.ground = mass, ground
        self._position, self._velocity = np.array([0.0, 0.0, ground]), NOTHING
        self._quaternion = self._wanted = LEVEL
        self._rates = NOTHING
        self._force = self._wanted_force = 0.0

    @property
    def weight(self) -> float:
        return weight_of(self.mass)

    def command(self, thrust: float, quaternion: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        self._wanted_force, self._wanted = max(0.0, thrust), quaternion / np.linalg.norm(quaternion)

    def stop_motors(self) -> None:
        self._wanted_force = 0.0

    def advance(self, duration: float) -> None:
        """Let time pass, in steps of at most 4 ms."""
        steps = max(1, math.ceil(duration / 0.004 - 1e-9))
        for _ in range(steps):
            self._step(duration / steps)

    def truth(self) -> PlantTruth:
        return PlantTruth(self._position, self._velocity, self._quaternion, self._rates, self._grounded)

    @property
    def _grounded(self) -> bool:
        return bool(self._position[2] <= self.ground + 1e-3)

    def _step(self, dt: float) -> None:
        self._force += (self._wanted_force - self._force) * min(1.0, dt / 0.03)
        if self._wanted_force > 0.0 and not (self._grounded and self._force < 0.9 * self.weight):
            w, *axis = multiply(conjugate(self._quaternion.tolist()), self._wanted.tolist())
            wanted_rates = np.clip(math.copysign(16.0, w) * np.array(axis), -4.0, 4.0)
            self._rates = self._rates + (wanted_rates - self._rates) * min(1.0, dt / 0.04)
        else:
            self._rates = NOTHING
        turned = np.array(multiply(self._quaternion.tolist(), [1.0, *(0.5 * dt * self._rates).tolist()]))
        self._quaternion = turned / np.linalg.norm(turned)
        force = self._force * thrust_axis(self._quaternion) - 0.3 * self._velocity
        self._velocity = self._velocity + dt * (force / self.mass - np.array([0.0, 0.0, weight_of(1.0)]))
        self._position = self._position + dt * self._velocity
        if self._position[2] <= self.ground:
            self._position[2] = self.ground
            self._velocity = np.array([0.0, 0.0, max(0.0, float(self._velocity[2]))])


def thrust_axis(quaternion: Array) -> Array:
    """The body's z axis in the world."""
    return np.array(rotate(quaternion.tolist(), (0.0, 0.0, 1.0)))


Place = tuple[int, int, int]
"""Latitude and longitude [1e-7 °], altitude above the sea [mm]."""
ZURICH: Place = (473_977_420, 85_455_940, 488_000)
"""Where the simulators of PX4 begin, and an emulated autopilot with satellites."""
_POSES_NEEDED = 10


@dataclass(frozen=True)
class Estimate:
    position: Array
    velocity: Array
    quaternion: Array
    body_rates: Array
    position_valid: bool
    on_earth: bool = True  # whether it knows where on earth that is, too: what has no home cannot return

    @property
    def yaw(self) -> float:
        return to_attitude(self.quaternion.tolist())[2]


class Estimator:
    """Truth plus an error."""

    history = 2.0  # for which truth is kept, to compare poses with [s]
    gain = 0.35  # share of an innovation that it takes over
    gate, reset_after = 0.5, 1.0  # innovation that is rejected [m], unless it persists [s]
    bias = np.array([0.04, -0.03, 0.01])  # of the accelerometers, (3,) [m/s²]: without aiding, it lets the error grow
    datum_delay = 1.0  # from the origin to the height's new zero [s]

    def __init__(
        self, now: float, truth: PlantTruth, timeout: float, needs_origin: bool, *, vision: bool, seed: int = 0
    ) -> None:
        self.vision, self.accepted_poses = vision, 0
        self.failed = False  # whether the position estimate is lost; may be set at any time
        self.origin: Place | None = None if vision else ZURICH
        """Where on earth the zero of its position is; None before it has one, or where its filter forgot it."""
        self.error = NOTHING  # of the position, shape (3,), world frame [m]
        self._needs_origin, self._timeout = needs_origin, timeout
        self._random = np.random.default_rng(seed)
        self._error_rate = NOTHING
        self._history: deque[tuple[float, Array]] = deque()
        self._aided_at, self._lift = -math.inf, 0.0
        self._rejected_since: float | None = None
        self._datum_due: float | None = None
        self.estimate = self.update(now, truth, 0.0)

    @property
    def navigates(self) -> bool:
        """Whether it has what it needs for a position, an origin perhaps excepted."""
        return not self.vision or self.accepted_poses >= _POSES_NEEDED

    def set_origin(self, now: float, armed: bool, place: Place) -> None:
        # ArduPilot sets the height that it believes soon after the first one to zero, unless it is armed. Poses are fused as they
        # are, and the height that it tells is larger by that from then on. The height that PX4 tells sinks by the altitude.
        self.origin = place
        if not self._needs_origin:
            self._lift = -1e-3 * place[2]
        elif not armed and self._datum_due is None:
            self._datum_due = now + self.datum_delay

    def update(self, now: float, truth: PlantTruth, dt: float) -> Estimate:
        self._history.append((now, truth.position))
        while now - self._history[0][0] > self.history:
            self._history.popleft()
        if not self.vision:
            self.error, self._error_rate, self._aided_at = self._random.normal(0.0, 0.002, 3), NOTHING, now
        elif now - self._aided_at > 0.2:
            self._error_rate = self._error_rate + dt * self.bias
            self.error = self.error + dt * self._error_rate
        if self._datum_due is not None and now >= self._datum_due:
            self._datum_due = math.inf
            self._lift = float(truth.position[2] + self.error[2]) if self.accepted_poses > 0 else 0.0
        located = self.origin is not None
        aided = self.navigates and now - self._aided_at < self._timeout and not self.failed
        valid = aided and (located or not self._needs_origin)
        position, velocity = truth.position + self.error + [0.0, 0.0, self._lift], truth.velocity + self._error_rate
        self.estimate = Estimate(position, velocity, truth.quaternion, truth.body_rates, valid, valid and located)
        return self.estimate

    def pose(self, now: float, stamp: float, position: Array) -> None:
        if not self.vision or not self._history[0][0] <= stamp <= now + 0.05:
            return
        times, places = zip(*self._history, strict=True)
        truth = np.array([np.interp(stamp, times, axis) for axis in np.transpose(places)])
        innovation, gain = position - truth - self.error, self.gain
        if self.navigates and float(np.linalg.norm(innovation)) > self.gate:
            self._rejected_since = now if self._rejected_since is None else self._rejected_since
            if now - self._rejected_since < self.reset_after:
                return
            gain = 1.0
        self.error, self._error_rate = self.error + gain * innovation, 0.5 * self._error_rate
        self._rejected_since, self._aided_at = None, now
        self.accepted_poses += 1
