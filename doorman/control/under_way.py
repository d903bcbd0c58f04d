r"""Commands under way: where those that were sent take the vehicle before one that is sent now shows.

A command of the attitude acts when the dead time d has passed, and then the attitude follows by the loop's lag τ
(`AttitudeLoop`). So a controller that corrects what it measures now is late by about :math:`T = d + \tau`. It corrects instead
what will be then, by the model and by the commands that were sent:

.. math::
    \hat v(t + T) = v(t) + \int_0^T \Big(\frac{R(\hat\Phi(t + s))\,f}{m} - g e_3 + \frac{\hat\delta}{m}\Big)\,ds, \qquad
    \hat p(t + T) = p(t) + \int_0^T \hat v(t + s)\,ds

along the ground, with :math:`\hat\Phi` from the attitude and rates now and from what was commanded at :math:`t + s - d`. Thrust
has no such lag: along the vertical nothing is predicted. The loop of position then has the margins that it would have with
neither lag nor dead time (tests/control/test_under_way.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.control.kernels.under_way_step import (
    AHEAD,
    ATTITUDE,
    COUNT,
    DEAD_TIME,
    FORCE,
    GIVEN,
    LAG,
    NOW,
    NUMBERS,
    RATE_GAIN,
    RATES,
    ROW,
    STEADY,
    carry_ahead,
    note_sent,
)
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.stored_at_once import stored_at_once

_KEPT = 1024
"""Commands that are kept: of half a second at the fastest controller."""


@stored_at_once
@dataclass(frozen=True, eq=False)
class Later:
    """What the commands under way make of the vehicle."""

    horizon: float
    """T [s]."""
    moved: Array
    """By how much the position will have changed, shape (3,), world frame [m]."""
    gained: Array
    """By how much the velocity will, shape (3,), world frame [m/s]."""


class UnderWay:
    """Ring of the commands that were sent, and the prediction by them for a mass [kg]."""

    def __init__(self, loop: AttitudeLoop, mass: float) -> None:
        self._mass = mass
        self._ring, self._numbers = np.zeros((_KEPT, ROW)), np.zeros(NUMBERS)
        self._given, self._found = np.zeros(GIVEN), np.zeros(4)
        self.fly_by(loop)
        self.note(0.0, np.zeros(3))  # compiles: nothing is in flight
        carry_ahead(self._ring, self._numbers, self._given, self._found)
        self._numbers[COUNT] = 0.0

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another loop from now on."""
        self._loop = loop
        self._numbers[[LAG, RATE_GAIN, DEAD_TIME]] = loop.lag, loop.rate_gain, loop.dead_time

    def note(self, now: float, attitude: Array) -> None:
        """Take in an attitude that is commanded from now on."""
        note_sent(self._ring, self._numbers, now, attitude)

    def later(
        self, now: float, attitude: Array, body_rates: Array, velocity: Array, rotors: Array, outer: Array
    ) -> Later:
        """Where the vehicle will be when what is sent now shows; `rotors` is in the body's axes, `outer` in the world's [N]."""
        given, horizon = self._given, self._loop.dead_time + self._loop.lag
        given[NOW], given[AHEAD] = now, horizon
        given[ATTITUDE:RATES], given[RATES:FORCE] = attitude, body_rates
        given[FORCE:STEADY], given[STEADY:GIVEN] = rotors / self._mass, outer[:2] / self._mass
        carry_ahead(self._ring, self._numbers, given, self._found)
        (x, y, to_x, to_y), (moves_x, moves_y, _) = self._found.tolist(), velocity.tolist()
        moved = np.array((x + horizon * moves_x, y + horizon * moves_y, 0.0))
        return Later(horizon, moved, np.array((to_x, to_y, 0.0)))
