r"""Observer of the vehicle as a point mass: velocity and outer force from positions alone.

.. math::
    \dot{\hat p} = \hat v + 3\omega e,\qquad
    \dot{\hat v} = \frac{F + \hat F_{out}}{m} + 3\omega^2 e,\qquad
    \dot{\hat F}_{out} = m\omega^3 e

with the rotors' and gravity's force F and the innovation e of the position: three poles at ω. Positions come T apart, so the
gains are those of the sampled observer with three poles at :math:`\theta = e^{-\omega T}`: :math:`1 - \theta^3`,
:math:`\tfrac32(1 - \theta^2)(1 - \theta)/T` and :math:`(1 - \theta)^3/T^2`. Gains in proportion to T would overshoot
after a gap. A position that is t old is compared with :math:`\hat p - t\hat v`, which slows the poles: to 0.94 from 0.89, at
T = 8 ms and t = 20 ms. (To carry what it corrects on to now keeps them, and is noisier: fewer doors were opened.) For
:math:`\omega t > 0.85` it would be unstable, so older positions are taken in with a smaller ω, and the model counts for more;
so are new ones soon after old ones, or delays that come and go would excite it. One that has been seen before is not compared
at all, so a gap is bridged by the model.

Of an arm with mass it is the centre of mass that moves so; O_B is where that is not.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LATEST = 0.6
"""Largest ω t; for older positions ω is less."""
AT_THE_ORIGIN = (np.zeros(3), np.zeros(3))
"""Centre of mass of a vehicle whose arm has no mass, and its velocity, from O_B."""
_FORGETS = 0.2
"""By so much a second the age that ω is chosen for falls, where positions are new again [s/s]."""


class VehicleObserver:
    """Position, velocity and outer force of the vehicle.

    Args:
        mass: m_A [kg].
        rate: ω of new positions [rad/s].
    """

    def __init__(self, mass: float, rate: float) -> None:
        self.mass = mass
        self.rate = rate
        self._seen: float | None = None
        self._late = 0.0
        self._center = AT_THE_ORIGIN
        self.position = np.zeros(3)
        """p̂ of O_B, shape (3,), world frame [m]."""
        self.velocity = np.zeros(3)
        """v̂ of O_B, shape (3,), world frame [m/s]."""
        self.outer_force = np.zeros(3)
        """F̂_out: wind, contact and whatever the model leaves out, shape (3,), world frame [N]."""

    def update(
        self, position: Array, measured_at: float, now: float, force: Array, time_step: float,
        center: tuple[Array, Array] = AT_THE_ORIGIN,
    ) -> None:  # fmt: skip
        """Advance by one period.

        Args:
            position: p of O_B, shape (3,), world frame [m].
            measured_at: When it was true [s].
            now: [s].
            force: F that acted since the last call: rotors and gravity, shape (3,), world frame [N].
            time_step: Since the last call [s].
            center: Place and velocity of the centre of mass from O_B, both of shape (3,), world axes [m], [m/s].
        """
        if self._seen is None:  # the centre of mass moves as it is believed to
            self.position, self.velocity = position.copy(), self.velocity - center[1]
            self._center, self._seen = center, measured_at
            return
        place, speed = self.position + self._center[0], self.velocity + self._center[1]
        self._center = center
        acceleration = (force + self.outer_force) / self.mass
        place = place + time_step * (speed + 0.5 * time_step * acceleration)
        speed = speed + time_step * acceleration
        if measured_at > self._seen:
            place, speed = self._corrected(place, speed, position + center[0], self._seen, measured_at, now)
        self.position, self.velocity = place - center[0], speed - center[1]

    def _corrected(
        self, place: Array, speed: Array, measured: Array, seen: float, measured_at: float, now: float
    ) -> tuple[Array, Array]:
        """Place and speed of the centre of mass with a new position taken in, and the outer force."""
        apart, self._seen = measured_at - seen, measured_at
        age = now - measured_at
        innovation = measured - (place - age * speed)
        self._late = max(age, self._late - _FORGETS * apart)
        rate = min(self.rate, LATEST / self._late) if self._late > 0.0 else self.rate
        kept = math.exp(-rate * apart)
        lost = 1.0 - kept
        self.outer_force = self.outer_force + self.mass * lost**3 / apart**2 * innovation
        return place + (1.0 - kept**3) * innovation, speed + 1.5 * (1.0 - kept**2) * lost / apart * innovation
