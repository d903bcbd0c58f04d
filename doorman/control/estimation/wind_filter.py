r"""The wind on the vehicle, which may turn: an extended Kalman filter of its force, of how fast it turns, and of the hinge.

.. math:: \dot w = \omega\,e_3 \times w + \nu_w,\qquad \dot\omega = \nu_\omega,\qquad \dot\tau = \sqrt{|\dot q|}\,\nu_\tau

Free flight shows the wind: it is all that is felt. In contact the filter goes on turning it as it turned before, and takes in
what no contact can explain: a pull, or more along the face than friction carries. The torque τ of friction and closer changes
with the angle and not with time: a leaf that moves under another push than it did here before is in another wind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.kernels.wind_step import correct_wind, predict_wind

Array = NDArray[np.float64]

_FIRST, _FIRST_TURN = 0.5, 0.1
"""Deviations at first of each part of the wind [N], and of its turning [rad/s]."""
_GUSTS, _TURNS = 0.06, 0.01
"""Growth of these in a second [N], [rad/s]."""
_FELT, _FELT_TIME = 0.12, 0.25
"""Noise of what the shipped vehicle feels, and the time after which it is another one [N], [s]."""
_NEAR_NOISE = 3.0
"""By so much less is believed what is felt near the leaf: it may be a touch."""
_BOUND, _BOUND_TIME = 0.3, 0.5
"""Noise of what contact can explain there, and the time after which it is another one [N], [s]."""
_SUDDEN = 0.5
"""Noise of the wind where contact is found to be lost, or to be there, of the shipped vehicle [N]."""
_HINGE, _HINGE_CHANGES = (1.0, 1.5), 0.7
"""τ of a room door at first with its deviation [N m], and its change with the square root of the way [N m/rad^0.5]."""
_MOVED, _MOVED_TIME, _MOVES = 0.2, 0.8, 0.012
"""Noise of the torque that moves such a leaf, the time after which it is another one, and the rate of a leaf that moves [N m],
[s], [rad/s]."""
_SETTLES = 0.6
"""For so long the observer of the outer force settles after take-off [s]."""
_STEADY = 0.15
"""Weaker wind has no direction that turns [N]."""


_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class WindFilter:
    """Filter of the wind in one flight.

    Args:
        force: Scale of the vehicle's forces.
        hinge: Scale of the hinge's torques.
    """

    def __init__(self, force: float = 1.0, hinge: float = 1.0) -> None:
        self._force, self._hinge = force, hinge
        self.state = np.array([0.0, 0.0, 0.0, 0.0, hinge * _HINGE[0]])
        """[w, ω, τ], shape (5,) [N], [rad/s], [N m]."""
        self.covariance = np.diag([_FIRST**2] * 3 + [_FIRST_TURN**2, (hinge * _HINGE[1]) ** 2])
        """Shape (5, 5)."""
        self._flown = 0.0
        self.predict(0.0)  # compiles, as the next line does: nothing is in flight
        correct_wind(self.state, self.covariance, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

    @property
    def force(self) -> Array:
        """w, shape (3,), world frame [N]."""
        return self.state[:3].copy()

    def predict(self, time_step: float) -> None:
        """Advance by one period.

        Args:
            time_step: Since the last call [s].
        """
        self._flown += time_step
        predict_wind(self.state, self.covariance, time_step, _STEADY, _GUSTS**2, _TURNS**2)

    def feel(self, felt: Array, near: bool, time_step: float) -> None:
        """Take in what is felt in free flight.

        Args:
            felt: Outer force, shape (3,), world frame [N].
            near: Whether the tip may touch something.
            time_step: Since the last call [s].
        """
        if self._flown < _SETTLES or time_step <= 0.0:
            return
        noise = (self._force * _FELT) ** 2 * (_NEAR_NOISE**2 if near else 1.0) * max(_FELT_TIME / time_step, 1.0)
        self._take_for_wind(felt, noise)

    def unexplained(self, direction: Array, force: float, time_step: float) -> None:
        """Take in a part of what the tip seems to feel that no contact makes.

        Args:
            direction: Of it, shape (3,), world frame.
            force: Wind less outer force along it, as far as no contact makes it [N].
            time_step: Since the last call [s].
        """
        if force != 0.0 and time_step > 0.0:
            self._correct(direction, -force, (self._force * _BOUND) ** 2 * max(_BOUND_TIME / time_step, 1.0))

    def pushed(
        self, normal: Array, levers: tuple[float, float], torque: float, opening: float, time_step: float
    ) -> None:
        """Take in what the rotors turn the leaf with. One that stands bears that much, or more.

        Args:
            normal: n_D, shape (3,), world frame.
            levers: Of the wind on the vehicle and of that on the leaf about the hinge [m].
            torque: Of the rotors, less what moves vehicle and leaf [N m].
            opening: Rate of the leaf [rad/s].
            time_step: Since the last call [s].
        """
        if time_step <= 0.0:
            return
        self.covariance[4, 4] += (self._hinge * _HINGE_CHANGES) ** 2 * abs(opening) * time_step
        lever, (x, y, up) = -sum(levers), normal.tolist()
        wind_x, wind_y, wind_up, _, hinge = self.state.tolist()
        off = torque - (lever * (x * wind_x + y * wind_y + up * wind_up) + hinge)
        if opening > _MOVES or off > 0.0:
            noise = (self._hinge * _MOVED) ** 2 * max(_MOVED_TIME / time_step, 1.0)
            correct_wind(self.state, self.covariance, lever * x, lever * y, lever * up, 1.0, off, noise)

    def met(self, normal: Array, more: float) -> None:
        """Take in that the tip presses harder than the wind seemed to say.

        Args:
            normal: n_D, shape (3,), world frame.
            more: By so much [N].
        """
        self._correct(normal, more, (self._force * _SUDDEN) ** 2)

    def lost(self, felt: Array) -> None:
        """Take in that there is no contact: what is felt is wind.

        Args:
            felt: Outer force, shape (3,), world frame [N].
        """
        self._take_for_wind(felt, (self._force * _SUDDEN) ** 2)

    def _take_for_wind(self, felt: Array, noise: float) -> None:
        for k, (x, y, up) in enumerate(_AXES):
            correct_wind(self.state, self.covariance, x, y, up, 0.0, float(felt[k] - self.state[k]), noise)

    def _correct(self, direction: Array, off: float, noise: float) -> None:
        x, y, up = direction.tolist()
        correct_wind(self.state, self.covariance, x, y, up, 0.0, off, noise)
