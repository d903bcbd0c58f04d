r"""How far the vehicle's attitude lags behind what it is told, as known by now.

.. math::
    \tau \dot\Phi = \Phi_d - \Phi

for roll and pitch, by least squares with a prior, over the last seconds in which they moved. What is built on top of the attitude
must be slower than that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.kernels.attitude_step import LAG, MEMORY, USUAL, learn_lag
from doorman.dynamics.attitude_loop import USUAL_LAG

Array = NDArray[np.float64]


class AttitudeResponse:
    """Lag of roll and pitch, updated every tick.

    Args:
        usual_lag: τ before anything is known, `vehicle.attitude_lag` [s].
    """

    def __init__(self, usual_lag: float = USUAL_LAG) -> None:
        self.memory = np.zeros(MEMORY)
        """What the kernel of `attitude_step` reads and writes, shape (MEMORY,)."""
        self.memory[LAG] = self.memory[USUAL] = usual_lag

    @property
    def lag(self) -> float:
        """τ [s]."""
        return float(self.memory[LAG])

    def update(self, told: Array, attitude: Array, body_rates: Array, time_step: float) -> None:
        """Take in a tick."""
        learn_lag(self.memory, np.array(told), np.array(attitude), np.array(body_rates), time_step)
