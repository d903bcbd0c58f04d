"""Kernels of attitude: Euler rates, and one period of `AttitudeResponse`, whose docstring has the equations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]

LAG, MOVED, BEHIND, USUAL, MEMORY = range(5)
"""Places in the memory: τ, the two averages, and τ before anything is known."""

LONGEST_LAG = 1.0
"""[s]."""
_WEIGHT = 0.02
"""Of the prior: mean square of the rates times their time [rad²/s]."""
_FORGETTING = 10.0
"""[s]."""


@kernel
def rates_of_euler(attitude: Array, body_rates: Array) -> tuple[float, float, float]:
    r"""Rates :math:`\dot\Phi = W(\Phi)\,\Omega`: three numbers, infinite or without sense near θ = ±π/2 [rad/s]."""
    cr, sr = math.cos(attitude[0]), math.sin(attitude[0])
    cp, tp = math.cos(attitude[1]), math.tan(attitude[1])
    turning = sr * body_rates[1] + cr * body_rates[2]
    return body_rates[0] + tp * turning, cr * body_rates[1] - sr * body_rates[2], turning / cp


@kernel
def learn_lag(memory: Array, told: Array, attitude: Array, body_rates: Array, time_step: float) -> None:
    """Take in one period."""
    roll_rate, pitch_rate, _ = rates_of_euler(attitude, body_rates)
    moved = roll_rate * roll_rate + pitch_rate * pitch_rate
    behind = roll_rate * (told[0] - attitude[0]) + pitch_rate * (told[1] - attitude[1])
    kept = math.exp(-time_step / _FORGETTING)
    memory[MOVED] = kept * memory[MOVED] + time_step * moved
    memory[BEHIND] = kept * memory[BEHIND] + time_step * behind
    lag = (memory[BEHIND] + _WEIGHT * memory[USUAL]) / (memory[MOVED] + _WEIGHT)
    memory[LAG] = min(max(lag, 0.0), LONGEST_LAG)
