"""Warm start: the previous plan, shifted to where the state is now."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]


@kernel
def nearest_shift(states: Array, state: Array, weights: Array, limit: int) -> float:
    """Number of steps along `states` at which its polyline is nearest to `state`.

    Args:
        states: Plan, shape (N + 1, nx).
        state: Shape (nx,).
        weights: Metric, shape (nx,).
        limit: Steps to look at, at most N.

    Returns:
        Shift in [0, limit].
    """
    best, shift = np.inf, 0.0
    for k in range(min(limit, states.shape[0] - 1)):
        along, length = 0.0, 1e-300
        for i in range(state.shape[0]):
            edge = states[k + 1, i] - states[k, i]
            along += weights[i] * edge * (state[i] - states[k, i])
            length += weights[i] * edge * edge
        part = min(max(along / length, 0.0), 1.0)
        distance = 0.0
        for i in range(state.shape[0]):
            gap = state[i] - states[k, i] - part * (states[k + 1, i] - states[k, i])
            distance += weights[i] * gap * gap
        if distance < best:
            best, shift = distance, k + part
    return shift


@kernel
def shift_rows(rows: Array, shift: float, out: Array) -> None:
    """Rows of a trajectory `shift` steps later, linearly interpolated; the last row is held.

    Args:
        rows: Shape (m, width).
        shift: Not negative.
        out: Shape (m, width).
    """
    last = rows.shape[0] - 1
    whole = int(shift)
    part = shift - whole
    for k in range(rows.shape[0]):
        first, second = min(k + whole, last), min(k + whole + 1, last)
        for j in range(rows.shape[1]):
            out[k, j] = (1.0 - part) * rows[first, j] + part * rows[second, j]
