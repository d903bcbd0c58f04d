"""A tip that moves along a direction until something stops it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.at_the_leaf import LARGEST_PUSH, SPEED_GAIN
from doorman.mission.motion import arm_rates_to
from doorman.model import Model

Array = NDArray[np.float64]

_STOPPED, _FARTHER = 0.7, 0.006
"""A tip that comes no farther by more than the second [m] for so long [s] has met something."""
_FLIES = 0.25
"""One that came farther within this time has not: what the vehicle feels is wind [s]."""
_FLOWN = 0.01
"""Way on which it gets up speed [m]."""
_SMOOTHED = 0.05
"""Time over which its place is smoothed [s]."""


class Feeler:
    """Moves the tip with little force. What stops it stands where the tip then is on average: it may bounce a little.

    Args:
        model: Model of the scenario.
        place: Of O_B, which is held beside the direction, shape (3,), world frame [m].
        yaw: ψ that is kept [rad].
        normal: Direction, unit vector, shape (3,), world frame.
        speed: Of the tip [m/s].
        steady_wind: That the position controller counts on while the tip pushes, shape (3,), world frame [N].
    """

    def __init__(self, model: Model, place: Array, yaw: float, normal: Array, speed: float, steady_wind: Array) -> None:
        self._model, self._place, self._yaw, self._normal = model, place, yaw, normal
        self._gain, self._most = SPEED_GAIN * model.scale.damping, LARGEST_PUSH * model.scale.force
        self._speed = speed
        self._tip: Array | None = None
        self._begun = self._mark = 0.0
        self._farther_at = 0.0
        self._sum, self._count = np.zeros(3), 0
        self._wind, self._steady_wind = 0.0, steady_wind
        self._beside = np.zeros(3)

    def step(self, estimate: Estimate, tip: Array, time_step: float) -> Setpoint:
        """Move on."""
        self._watch(estimate.time, tip, time_step)
        if not self._has_flown or self.comes_on(estimate.time):
            self._wind = float(self._normal @ estimate.wind)
            self._beside = self._against_gusts(estimate.wind)
        push = self._gain * (self._speed - float(self._normal @ estimate.velocity))
        push = min(max(push, -self._most), self._most) - self._wind
        rest, arm = np.zeros(3), arm_rates_to(self._model.start_arm, estimate.arm_angles)
        return Setpoint(self._place, rest, self._beside, self._yaw, rest, self._normal, arm, push)

    def _against_gusts(self, wind: Array) -> Array:
        """Acceleration that holds the vehicle beside the direction, shape (3,), world frame [m/s²]."""
        gust = wind - self._steady_wind
        gust = gust - float(self._normal @ gust) * self._normal
        return np.array([*(-gust[:2] / self._model.vehicle.mass), 0.0])

    def met(self, now: float) -> Array | None:
        """Where the tip was stopped, shape (3,), world frame [m]; None as long as it comes on."""
        stopped = now - self._farther_at >= _STOPPED
        return self._sum / self._count if stopped and self._has_flown else None

    def comes_on(self, now: float) -> bool:
        """Whether the tip has come farther just now."""
        return now - self._farther_at < _FLIES

    @property
    def _has_flown(self) -> bool:
        return self._mark > self._begun + _FLOWN

    def _watch(self, now: float, tip: Array, time_step: float) -> None:
        """Take in where the tip is."""
        if self._tip is None:
            self._tip, self._begun = tip, float(self._normal @ tip)
            self._mark = self._begun
        self._tip = self._tip + min(time_step / _SMOOTHED, 1.0) * (tip - self._tip)
        way = float(self._normal @ self._tip)
        if way > self._mark + _FARTHER:
            self._mark, self._farther_at = way, now
            self._sum, self._count = np.zeros(3), 0
        self._sum, self._count = self._sum + tip, self._count + 1
