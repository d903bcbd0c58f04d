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
:math:`\omega t > 0.85` it would be unstable, so older positions are taken in with a smaller ω, and the model counts for more.
So are new ones soon after old ones, or delays that come and go would excite it. One that has been seen before is not compared
at all, so a gap is bridged by the model.

Of an arm with mass it is the centre of mass that moves so; O_B is where that is not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.kernels.vehicle_step import GIVEN, OUTER_FORCE, POSITION, SEEN, SIZE, VELOCITY, advance_vehicle
from doorman.control.kernels.vehicle_step import LATEST as LATEST

Array = NDArray[np.float64]

AT_THE_ORIGIN = (np.zeros(3), np.zeros(3))
"""Centre of mass of a vehicle whose arm has no mass, and its velocity, from O_B."""


class VehicleObserver:
    """Position, velocity and outer force of the vehicle.

    Args:
        mass: m_A [kg].
        rate: ω of new positions [rad/s].
    """

    def __init__(self, mass: float, rate: float) -> None:
        self.mass = mass
        self.rate = rate
        self.memory, self._given = np.zeros(SIZE), np.zeros(GIVEN)
        """What the kernel of `vehicle_step` writes to, shape (SIZE,)."""
        self.memory[SEEN] = np.nan

    @property
    def position(self) -> Array:
        """p̂ of O_B, shape (3,), world frame, written to by every update [m]."""
        return self.memory[POSITION : POSITION + 3]

    @property
    def velocity(self) -> Array:
        """v̂ of O_B, shape (3,), world frame, written to by every update [m/s]."""
        return self.memory[VELOCITY : VELOCITY + 3]

    @property
    def outer_force(self) -> Array:
        """F̂_out: wind, contact and what the model leaves out, shape (3,), world frame, written to by every update [N]."""
        return self.memory[OUTER_FORCE : OUTER_FORCE + 3]

    def update(
        self, position: Array, measured_at: float, now: float, force: Array, time_step: float,
        center: tuple[Array, Array] = AT_THE_ORIGIN,
    ) -> None:  # fmt: skip
        """Advance by one period."""
        np.concatenate((position, force, *center), out=self._given)
        advance_vehicle(self.memory, self._given, self.mass, self.rate, measured_at, now, time_step)
