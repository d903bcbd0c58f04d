r"""What emulated servos move: an interface, and joints that follow their goal with a first-order lag.

.. math::
    \dot r = (g - r)/\tau, \qquad \dot\eta = r

g is the goal rate of a powered joint; without power it is zero, since the gears do not turn freely.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.arrays import Array
from doorman.checks import vector

CURRENT_PER_ACCELERATION = 0.005
"""Current that the default plant draws to speed up [A s²/rad]."""


@dataclass(frozen=True)
class ServoMotion:
    angles: Array  # shape (n,) [rad]
    rates: Array  # shape (n,) [rad/s]
    currents: Array  # positive where they push the angle up, shape (n,) [A]


class ServoPlant(Protocol):
    """Mechanics behind emulated servos; called from the emulator's thread."""

    def drive(self, time: float, rates: Array, powered: NDArray[np.bool_]) -> None:
        """Take goal rates; they hold until the next call."""

    def motion(self, time: float) -> ServoMotion:
        """Motion at a time not before that of the last call."""


class LaggingJoints:
    """Joints that follow their goal rate with a first-order lag, whatever loads them."""

    def __init__(
        self, angles: ArrayLike, time_constant: float = 0.02, stops: tuple[float, float] = (-math.inf, math.inf)
    ) -> None:
        self._angles = vector(angles, np.size(angles), "angles")
        self._rates = np.zeros_like(self._angles)
        self._goals = np.zeros_like(self._angles)
        self._time_constant = time_constant
        self._stops = stops
        self._time: float | None = None

    def drive(self, time: float, rates: Array, powered: NDArray[np.bool_]) -> None:
        self._advance(time)
        self._goals = np.where(powered, rates, 0.0)

    def motion(self, time: float) -> ServoMotion:
        self._advance(time)
        accelerations = (self._goals - self._rates) / self._time_constant
        return ServoMotion(self._angles.copy(), self._rates.copy(), CURRENT_PER_ACCELERATION * accelerations)

    def _advance(self, time: float) -> None:
        """Solve the lag exactly up to a time."""
        step = 0.0 if self._time is None else max(time - self._time, 0.0)
        self._time = time
        decay = math.exp(-step / self._time_constant)
        difference = self._rates - self._goals
        self._angles = self._angles + self._goals * step + difference * self._time_constant * (1.0 - decay)
        self._rates = self._goals + difference * decay
        stopped = np.clip(self._angles, *self._stops)
        self._rates = np.where(stopped == self._angles, self._rates, 0.0)
        self._angles = stopped
