r"""Observer of how far roll and pitch settle beside what is commanded, for reasons that the plan does not know.

The attitude loop that plans count on, with what the tip's force is known to turn the vehicle by, :math:`b_F`,
and an offset b (the command is the one that acts by now):

.. math:: \dot\phi = \omega,\qquad \dot\omega = \kappa_r\big(\kappa_a(\phi_c + b_F + b - \phi) - \omega\big),\qquad \dot b = 0

The three poles of the observer are at :math:`\kappa_a`, or at 10 1/s where that is slower. An autopilot's integrator takes a
steady moment up: then b is :math:`-b_F`, and of the other sign as soon as the moment ends.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.dynamics.attitude_loop import AttitudeLoop

_QUICK = 10.0
"""Least speed of the poles [1/s]: integrators of autopilots take a moment up within half a second."""
_MOST = 0.5
"""Largest offset, as a share of the largest tilt."""


class TiltObserver:
    """Offset of roll and pitch from what is commanded, up to a largest tilt [rad]."""

    def __init__(self, loop: AttitudeLoop, max_tilt: float) -> None:
        self.fly_by(loop)
        self._most = _MOST * max_tilt
        self._tilt: list[float] | None = None
        self._rates = [0.0, 0.0]
        self.offset = np.zeros(2)
        """b, shape (2,) [rad]."""

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another loop from now on."""
        self._gain, self._rate_gain = loop.gain, loop.rate_gain

    def forget(self) -> None:
        """Begin anew: nothing turns the vehicle."""
        self._tilt, self._rates, self.offset = None, [0.0, 0.0], np.zeros(2)

    def update(self, tilt: Array, commanded: Array, turned: Array, time_step: float) -> None:
        """Take in a measured tilt, and the command that has acted since the last one: it was sent a dead time before."""
        measured: list[float] = tilt.tolist()
        wanted: list[float] = commanded.tolist()
        if self._tilt is None:
            self._tilt = measured
            return
        p, k, offsets = self._gain, self._rate_gain, self.offset.tolist()
        pole = max(p, _QUICK)
        first = 3.0 * pole - k
        second, third = 3.0 * pole**2 - k * p - k * first, pole**3 / (k * p)
        for axis, push in enumerate(turned.tolist()):
            believed, rate, offset = self._tilt[axis], self._rates[axis], offsets[axis]
            error = measured[axis] - believed
            bent = k * (p * (wanted[axis] + push + offset - believed) - rate) + second * error
            self._tilt[axis] = believed + time_step * (rate + first * error)
            self._rates[axis] = rate + time_step * bent
            offsets[axis] = min(max(offset + time_step * third * error, -self._most), self._most)
        self.offset = np.array(offsets)
