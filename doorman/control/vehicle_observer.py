r"""Observer of the vehicle as a point mass: velocity and outer force from positions alone.

.. math::
    \dot{\hat p} = \hat v + 3\omega e,\qquad
    \dot{\hat v} = \frac{F + \hat F_{out}}{m} + 3\omega^2 e,\qquad
    \dot{\hat F}_{out} = m\omega^3 e

with the rotors' and gravity's force F and the innovation e of the position: three poles at ω. A position that is t old is
compared with :math:`\hat p - t\hat v`; one that has been seen before is not compared at all, so a gap is bridged by the model.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LONGEST = 0.04
"""Largest time that one innovation counts for [s]: after a gap it would overshoot."""


class VehicleObserver:
    """Position, velocity and outer force of the vehicle.

    Args:
        mass: m_A [kg].
        rate: ω [rad/s].
    """

    def __init__(self, mass: float, rate: float) -> None:
        self.mass = mass
        self.rate = rate
        self._seen: float | None = None
        self.position = np.zeros(3)
        """p̂, shape (3,), world frame [m]."""
        self.velocity = np.zeros(3)
        """v̂, shape (3,), world frame [m/s]."""
        self.outer_force = np.zeros(3)
        """F̂_out: wind, contact and whatever the model leaves out, shape (3,), world frame [N]."""

    def update(self, position: Array, measured_at: float, now: float, force: Array, time_step: float) -> None:
        """Advance by one period.

        Args:
            position: p, shape (3,), world frame [m].
            measured_at: When it was true [s].
            now: [s].
            force: F that acted since the last call: rotors and gravity, shape (3,), world frame [N].
            time_step: Since the last call [s].
        """
        if self._seen is None:
            self.position, self._seen = position.copy(), measured_at
            return
        acceleration = (force + self.outer_force) / self.mass
        self.position = self.position + time_step * (self.velocity + 0.5 * time_step * acceleration)
        self.velocity = self.velocity + time_step * acceleration
        if measured_at <= self._seen:
            return
        weight, rate = min(measured_at - self._seen, _LONGEST), self.rate
        self._seen = measured_at
        innovation = position - (self.position - (now - measured_at) * self.velocity)
        self.position = self.position + 3.0 * rate * weight * innovation
        self.velocity = self.velocity + 3.0 * rate**2 * weight * innovation
        self.outer_force = self.outer_force + self.mass * rate**3 * weight * innovation
