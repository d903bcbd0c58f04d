"""From states of the Lagrangian model, [Φ, α, Φ̇, α̇, H], to those of the simplified one, [Φ, α, α̇, H]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.dynamics.lagrangian_acceleration import directions, euler_map

Array = NDArray[np.float64]


@kernel
def reduce_state(x: Array, out: Array) -> None:
    """Leave Φ̇ out: `out` (5 + n,) from `x` (8 + n,)."""
    for i in range(4):
        out[i] = x[i]
    for i in range(7, x.shape[0]):
        out[i - 3] = x[i]


@kernel
def reduce_trajectory(states: Array, inputs: Array, reduced_states: Array, reduced_inputs: Array) -> None:
    """States, and inputs with the body rates Ω = W⁻¹Φ̇ in the torques' place.

    Args:
        states: x, shape (m, 8 + n).
        inputs: [f_t, T, Ḣ_d] at the first of them, shape (≤ m, 4 + n).
        reduced_states: [Φ, α, α̇, H], shape (m, 5 + n).
        reduced_inputs: [f_t, Ω, Ḣ_d], shape of the inputs.
    """
    for k in range(states.shape[0]):
        reduce_state(states[k], reduced_states[k])
    for k in range(inputs.shape[0]):
        x = states[k]
        rates = euler_map(directions(x[0], x[1], x[3] - x[2]), (x[4], x[5], x[6]))
        for i in range(inputs.shape[1]):
            reduced_inputs[k, i] = inputs[k, i]
        for i in range(3):
            reduced_inputs[k, 1 + i] = rates[i]
