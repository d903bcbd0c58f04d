r"""The wind on the vehicle, which may turn: an extended Kalman filter of its force, of how fast it turns, and of the hinge.

.. math:: \dot w = \omega\,e_3 \times w + \nu_w,\qquad \dot\omega = \nu_\omega,\qquad \dot\tau = \sqrt{|\dot q|}\,\nu_\tau

Free flight shows the wind: it is all that is felt. In contact the filter goes on turning it as it turned before, and takes in
what no contact can explain: a pull, or more along the face than friction carries. The torque τ of friction and closer changes
with the angle and not with time, by the closer's stiffness as far as it is known. A leaf that moves under another push than it
did here before is in another wind. A sensor of the tip's force λ tells the wind along the normal from the outer force F,

.. math:: n_D^T w = n_D^T F + \lambda .
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from doorman.control.kernels.wind_step import (
    WindMemory,
    advance_wind,
    feel_wind,
    lose_contact,
    meet_contact,
    take_push,
    take_tip_force,
    take_unexplained,
)
from doorman.numba_types.handles import held

Array = NDArray[np.float64]

_FIRST, _FIRST_TURN = 0.5, 0.1
"""Deviations at first of each part of the wind on the shipped vehicle [N], and of its turning [rad/s]."""
_HINGE = (1.0, 1.5)
"""τ of a room door at first with its deviation [N m]."""


class WindFilter:
    """Filter of the wind in one flight.

    Args:
        force: Scale of the vehicle's forces.
        hinge: Scale of the hinge's torques.
    """

    def __init__(self, force: float = 1.0, hinge: float = 1.0) -> None:
        state = np.array([0.0, 0.0, 0.0, 0.0, hinge * _HINGE[0]])
        covariance = np.diag([(force * _FIRST) ** 2] * 3 + [_FIRST_TURN**2, (hinge * _HINGE[1]) ** 2])
        self.memory = WindMemory(state, covariance, np.zeros(1), np.array([force, hinge], dtype=np.float64))
        """What the kernels of `wind_step` read and write."""

    @cached_property
    def _held(self) -> WindMemory:
        return held(self.memory)

    @property
    def state(self) -> Array:
        """[w, ω, τ], shape (5,), written to by every update [N], [rad/s], [N m]."""
        return self.memory.state

    @property
    def covariance(self) -> Array:
        """Shape (5, 5), written to by every update."""
        return self.memory.covariance

    @property
    def force(self) -> Array:
        """w, shape (3,), world frame [N]."""
        return self.state[:3].copy()

    def predict(self, time_step: float) -> None:
        """Advance by one period."""
        advance_wind(self._held, time_step)

    def feel(self, felt: Array, near: bool, time_step: float) -> None:
        """Take in what is felt in free flight."""
        feel_wind(self._held, np.array(felt), near, time_step)

    def unexplained(self, direction: Array, force: float, time_step: float) -> None:
        """Take in a part of what the tip seems to feel that no contact makes."""
        x, y, up = direction.tolist()
        take_unexplained(self._held, x, y, up, force, time_step)

    def pushed(
        self,
        normal: Array,
        levers: tuple[float, float],
        torque: float,
        opening: float,
        time_step: float,
        closer: float = 0.0,
    ) -> None:
        """Take in what the rotors turn the leaf with. One that stands bears that much, or more."""
        take_push(self._held, tuple(normal.tolist()), sum(levers), torque, opening, closer, time_step)

    def met(self, normal: Array, more: float) -> None:
        """Take in that the tip presses harder than the wind seemed to say."""
        x, y, up = normal.tolist()
        meet_contact(self._held, x, y, up, more)

    def pressed(self, normal: Array, force: float, noise: float, offset: float, time_step: float) -> None:
        """Take in the wind along the normal, as a sensor of the tip's force tells it."""
        take_tip_force(self._held, tuple(normal.tolist()), force, noise, offset, time_step)

    def lost(self, felt: Array) -> None:
        """Take in that there is no contact: what is felt is wind."""
        lose_contact(self._held, np.array(felt))
