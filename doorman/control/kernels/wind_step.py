"""Kernels of `WindFilter`: its prediction and its correction; its docstring has the equations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]

TURN, STATES = 3, 5
"""Place of the wind's turning in the state [w, ω, τ], and the state's size."""


@kernel
def predict_wind(z: Array, p: Array, time_step: float, steady: float, gusts: float, turns: float) -> None:
    """Turn the wind on by one period.

    Args:
        z: State, shape (5,), written to.
        p: Covariance, shape (5, 5), written to.
        time_step: [s].
        steady: Weaker wind has no direction that turns [N].
        gusts: Variance that each part of the wind gains in a second [N²/s].
        turns: And its turning [rad²/s³].
    """
    x, y = z[0], z[1]
    c, s = math.cos(z[TURN] * time_step), math.sin(z[TURN] * time_step)
    z[0], z[1] = c * x - s * y, s * x + c * y
    by_turn = time_step if math.hypot(x, y) > steady else 0.0
    to_x, to_y = -by_turn * z[1], by_turn * z[0]
    for k in range(STATES):
        a, b, turn = p[0, k], p[1, k], p[TURN, k]
        p[0, k], p[1, k] = c * a - s * b + to_x * turn, s * a + c * b + to_y * turn
    for k in range(STATES):
        a, b, turn = p[k, 0], p[k, 1], p[k, TURN]
        p[k, 0], p[k, 1] = c * a - s * b + to_x * turn, s * a + c * b + to_y * turn
    for k in range(3):
        p[k, k] += time_step * gusts
    p[TURN, TURN] += time_step * turns


@kernel
def correct_wind(z: Array, p: Array, x: float, y: float, up: float, torque: float, off: float, noise: float) -> None:
    """Kalman's step for one number.

    Args:
        z: State, shape (5,), written to.
        p: Covariance, shape (5, 5), written to.
        x: What the number changes by with w_x,
        y: w_y,
        up: w_z,
        torque: and with τ.
        off: What was measured, less what was expected.
        noise: Variance of the measurement.
    """
    variance = noise
    spread = (
        p[0, 0] * x + p[0, 1] * y + p[0, 2] * up + p[0, 4] * torque,
        p[1, 0] * x + p[1, 1] * y + p[1, 2] * up + p[1, 4] * torque,
        p[2, 0] * x + p[2, 1] * y + p[2, 2] * up + p[2, 4] * torque,
        p[3, 0] * x + p[3, 1] * y + p[3, 2] * up + p[3, 4] * torque,
        p[4, 0] * x + p[4, 1] * y + p[4, 2] * up + p[4, 4] * torque,
    )
    variance += x * spread[0] + y * spread[1] + up * spread[2] + torque * spread[4]
    for k in range(STATES):
        z[k] += spread[k] / variance * off
        for j in range(STATES):
            p[k, j] -= spread[k] / variance * spread[j]
