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
from doorman.compilation import entry
from doorman.control.kernels.under_way_step import BelievedLoop, Commands, Now, carry_ahead, note_sent
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.numba_types.handles import held
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
        self._mass, self._believed, self._now = mass, BelievedLoop(), Now()
        self._commands = held(Commands(self._believed, np.zeros(_KEPT), np.zeros((_KEPT, 3)), self._now))
        self._note = entry(note_sent, self._commands, 0.0, 0.0, 0.0, 0.0)
        self._carry = entry(carry_ahead, self._commands, 0.0, 0.0)
        self.fly_by(loop)

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another loop from now on."""
        self._loop, believed = loop, self._believed
        believed.lag, believed.rate_gain, believed.dead_time = loop.lag, loop.rate_gain, loop.dead_time

    def note(self, now: float, attitude: Array) -> None:
        """Take in an attitude that is commanded from now on."""
        self._note(self._commands, now, *attitude.tolist())

    def later(
        self, now: float, attitude: Array, body_rates: Array, velocity: Array, rotors: Array, outer: Array
    ) -> Later:
        """Where the vehicle will be when what is sent now shows; `rotors` is in the body's axes, `outer` in the world's [N]."""
        known, horizon = self._now, self._loop.dead_time + self._loop.lag
        known.attitude, known.body_rates = attitude, body_rates
        known.rotors, known.outer = rotors / self._mass, outer[:2] / self._mass
        x, y, to_x, to_y = self._carry(self._commands, now, horizon)
        moves_x, moves_y, _ = velocity.tolist()
        moved = np.array((x + horizon * moves_x, y + horizon * moves_y, 0.0))
        return Later(horizon, moved, np.array((to_x, to_y, 0.0)))
