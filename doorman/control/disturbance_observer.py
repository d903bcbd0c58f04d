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
from numpy.typing import NDArray

Array = NDArray[np.float64]


_UNWINDING = 10.0
"""How much faster than the observer its inner state follows at the bound; not by more than all of it in one period."""


class DisturbanceObserver:
    """Estimate of the force that the nominal model does not explain.

    Args:
        mass: m [kg].
        rate: 1/τ [rad/s].
        damping: a_1; a_0 is 1.
        limit: Bound of the estimate on every axis [N].
    """

    def __init__(self, mass: float, rate: float, damping: float = 2.0, limit: float = np.inf) -> None:
        self.rate = rate
        self.damping = damping
        self.limit = limit
        self._gain = mass * rate**2
        self._inner = np.zeros(3)
        self._outer: Array | None = None
        self.estimate = np.zeros(3)
        """δ̂, shape (3,), world frame [N]."""

    def update(self, position: Array, force: Array, time_step: float) -> Array:
        """Advance by one period.

        Args:
            position: p now, shape (3,), world frame [m].
            force: F that acted since the last call: thrust, gravity and every planned reaction, shape (3,) [N].
            time_step: Since the last call [s].

        Returns:
            δ̂, shape (3,), world frame [N].
        """
        if self._outer is None:
            self._outer = -self._gain * position  # starts from δ̂ = 0, wherever the vehicle is
        self._inner -= time_step * self.rate**2 * (self.estimate + force)
        self._outer += time_step * (self._inner - self.damping * self.rate * self.estimate)
        raw = self._gain * position + self._outer
        self.estimate = np.clip(raw, -self.limit, self.limit)
        excess = self.estimate - raw  # anti-windup: both states stay where the bound is reached, not beyond
        self._outer += excess
        self._inner += _UNWINDING * self.rate / max(_UNWINDING * self.rate * time_step, 1.0) * excess
        return self.estimate

    def align(self, direction: Array, disturbance: Array, velocity: Array) -> None:
        """Set the estimate along one direction, at rest there: for a bumpless change of what holds the vehicle.

        Args:
            direction: Unit vector, shape (3,).
            disturbance: δ̂ from now on, of which the share along `direction` is taken, shape (3,) [N].
            velocity: ṗ, shape (3,) [m/s].
        """
        if self._outer is None:
            return
        change = (direction @ (disturbance - self.estimate)) * direction
        self.estimate = self.estimate + change
        self._outer = self._outer + change
        settled = self.damping * self.rate * self.estimate - self._gain * velocity
        self._inner = self._inner + (direction @ (settled - self._inner)) * direction

    def resume(self, position: Array, velocity: Array, disturbance: Array) -> None:
        """Begin anew with a known disturbance.

        Args:
            position: p now, shape (3,), world frame [m].
            velocity: ṗ, shape (3,), world frame [m/s].
            disturbance: δ̂ from now on, shape (3,), world frame [N].
        """
        self.estimate = np.clip(disturbance, -self.limit, self.limit)
        self._outer = self.estimate - self._gain * position
        self._inner = self.damping * self.rate * self.estimate - self._gain * velocity
