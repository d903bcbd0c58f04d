"""A tip that moves along a direction until something stops it."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.control.at_the_leaf import LARGEST_PUSH, SPEED_GAIN
from doorman.control.estimation.estimator import Estimate
from doorman.control.motion import arm_rates_to
from doorman.control.position_controller import Setpoint
from doorman.model import Model

_PRESSES, _UNLOADS = 0.3, 0.3
"""Time for which a tip that is probably stopped presses on, and then unloads to a half, before it has met something: a gust that
stops the tip blows it back meanwhile [s]."""


class Feeler:
    """Moves the tip with little force along a unit normal, at a speed [m/s], O_B held beside that at a place in the world [m].

    What stops it, by the estimate, stands where the tip then is on average. The position controller counts on `steady_wind`.
    """

    def __init__(self, model: Model, place: Array, yaw: float, normal: Array, speed: float, steady_wind: Array) -> None:
        self._model, self._place, self._yaw, self._normal = model, place, yaw, normal
        self._gain, self._most = SPEED_GAIN * model.scale.damping, LARGEST_PUSH * model.scale.force
        self._speed, self._steady_wind = speed, steady_wind
        self._stopped_at: float | None = None
        self._sum, self._count = np.zeros(3), 0

    def step(self, estimate: Estimate, tip: Array) -> Setpoint:
        """Move on."""
        if not estimate.stopped:
            self._stopped_at, self._sum, self._count = None, np.zeros(3), 0
        else:
            self._stopped_at = estimate.time if self._stopped_at is None else self._stopped_at
            self._sum, self._count = self._sum + tip, self._count + 1
        unloads = self._stopped_at is not None and estimate.time - self._stopped_at > _PRESSES
        speed = 0.5 * self._speed if unloads else self._speed
        arm, turns = tip - estimate.position, float(estimate.attitude_rates[2])
        comes_on = estimate.velocity + turns * np.array(
            [-arm[1], arm[0], 0.0]
        )  # a vehicle may turn about a tip that is stopped
        push = self._gain * (speed - float(self._normal @ comes_on))
        push = min(max(push, -self._most), self._most) - float(self._normal @ estimate.wind)
        rest, arm_rates = np.zeros(3), arm_rates_to(self._model.start_arm, estimate.arm_angles)
        gust = estimate.wind - self._steady_wind
        gust = gust - float(self._normal @ gust) * self._normal  # held against beside the direction
        beside = np.array([*(-gust[:2] / self._model.vehicle.mass), 0.0])
        return Setpoint(self._place, rest, beside, self._yaw, rest, self._normal, arm_rates, push)

    def met(self, now: float) -> Array | None:
        """Where the tip was stopped, shape (3,), world frame [m]; None as long as it comes on."""
        stopped = self._stopped_at is not None and now - self._stopped_at >= _PRESSES + _UNLOADS
        return self._sum / self._count if stopped else None
