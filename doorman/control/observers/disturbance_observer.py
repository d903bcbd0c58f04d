r"""Disturbance observer of a point mass, one for all axes (Kim, Choi and Kim, IEEE TCST 2018).

The plant is :math:`m\ddot p = F + \delta`. The observer is :math:`\hat\delta = Q(s)\,[m s^2 p - F]` with

.. math:: Q(s) = \frac{a_0}{(\tau s)^2 + a_1 \tau s + a_0}

in a form that differentiates p never: with c = a_0 m/τ²,

.. math::
    \hat\delta = c\,p + \mu,\qquad
    \dot\mu = -\frac{a_1}{\tau}\hat\delta + \nu,\qquad
    \dot\nu = -\frac{a_0}{\tau^2}(\hat\delta + F)
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.control.kernels.control_step import ObserverMemory, align_disturbance, observe_disturbance


class DisturbanceObserver:
    """Estimate of the force that the nominal model does not explain: m [kg], 1/τ [rad/s], a_1, and a limit on every axis [N]."""

    def __init__(self, mass: float, rate: float, damping: float = 2.0, limit: float = np.inf) -> None:
        self.rate = rate
        self.damping = damping
        self.limit = limit
        self._gain = mass * rate**2
        self.memory = ObserverMemory(gain=self._gain, rate=rate, damping=damping, limit=limit)
        """What kernels read and write."""
        align_disturbance(self.memory, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, np.zeros(3))  # compiles: nothing is in flight

    @property
    def estimate(self) -> Array:
        """δ̂, shape (3,), world frame, written to by every update [N]."""
        return self.memory.estimate

    def update(self, position: Array, force: Array, time_step: float) -> Array:
        """Advance by one period."""
        observe_disturbance(self.memory, np.array(position), np.array(force), time_step)
        return self.estimate.copy()

    def align(self, direction: Array, disturbance: Array, velocity: Array) -> None:
        """Set the estimate along one direction, at rest there: for a bumpless change of what holds the vehicle."""
        (x, y, up), (to_x, to_y, to_up) = direction.tolist(), disturbance.tolist()
        align_disturbance(self.memory, x, y, up, to_x, to_y, to_up, np.array(velocity))

    def resume(self, position: Array, velocity: Array, disturbance: Array) -> None:
        """Begin anew with a known disturbance."""
        memory = self.memory
        memory.estimate = known = np.clip(disturbance, -self.limit, self.limit)
        memory.outer = known - self._gain * position
        memory.inner = self.damping * self.rate * known - self._gain * velocity
        memory.started = 1
