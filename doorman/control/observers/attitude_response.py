r"""How far the vehicle's attitude lags behind what it is told, as known by now.

.. math::
    \tau \dot\Phi = \Phi_d - \Phi

for roll and pitch, by least squares with a prior, over the last seconds in which they moved. What is built on top of the attitude
must be slower than that.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.dynamics.attitude_loop import USUAL_LAG
from doorman.kinematics.rotations import euler_rates

Array = NDArray[np.float64]

LONGEST_LAG = 1.0
"""[s]."""
_WEIGHT = 0.02
"""Of that prior: mean square of the rates times their time [rad²/s]."""
_FORGETTING = 10.0
"""[s]."""


class AttitudeResponse:
    """Lag of roll and pitch, updated every tick.

    Args:
        usual_lag: τ before anything is known, `vehicle.attitude_lag` [s].
    """

    def __init__(self, usual_lag: float = USUAL_LAG) -> None:
        self.lag = self._usual_lag = usual_lag
        """τ [s]."""
        self._moved = self._behind = 0.0

    def update(self, told: Array, attitude: Array, body_rates: Array, time_step: float) -> None:
        """Take in a tick.

        Args:
            told: Φ_d that was commanded last, shape (3,) [rad].
            attitude: Φ, shape (3,) [rad].
            body_rates: Ω, shape (3,) [rad/s].
            time_step: Since the last one [s].

        Raises:
            SingularityError: if θ = ±π/2.
        """
        roll, pitch = float(attitude[0]), float(attitude[1])
        roll_rate, pitch_rate, _ = euler_rates(attitude, body_rates)
        moved = roll_rate * roll_rate + pitch_rate * pitch_rate
        behind = roll_rate * (float(told[0]) - roll) + pitch_rate * (float(told[1]) - pitch)
        kept = math.exp(-time_step / _FORGETTING)
        self._moved = kept * self._moved + time_step * moved
        self._behind = kept * self._behind + time_step * behind
        lag = (self._behind + _WEIGHT * self._usual_lag) / (self._moved + _WEIGHT)
        self.lag = min(max(lag, 0.0), LONGEST_LAG)
