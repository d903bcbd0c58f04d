"""A problem of a user's own: a mass on a rail before a wall, with a speed limit; its kernels are registered by type."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.ocp import functions

Array = NDArray[np.float64]


class Rail(NamedTuple):
    """Numbers of the kernels."""

    time_step: float
    wall: float
    speed_limit: float
    slope: float
    """Factor on the Jacobian of the input: 1, or something else to make it wrong."""


@functions.implement(functions.step, Rail)
@kernel
def _step(rail: Rail, x: Array, u: Array, out: Array) -> None:
    h = rail.time_step
    out[0] = x[0] + h * x[1] + 0.5 * h * h * u[0]
    out[1] = x[1] + h * u[0]


@functions.implement(functions.linearize_step, Rail)
@kernel
def _linearize_step(rail: Rail, x: Array, u: Array, out: Array) -> None:
    h = rail.time_step
    out[:, :] = 0.0
    out[0, 0] = 1.0
    out[0, 1] = h
    out[1, 1] = 1.0
    out[0, 2] = 0.5 * h * h * rail.slope
    out[1, 2] = h * rail.slope


@functions.implement(functions.constrain, Rail)
@kernel
def _constrain(rail: Rail, x: Array, h: Array) -> None:
    h[0] = x[0] - rail.wall
    h[1] = x[1] - rail.speed_limit


@functions.implement(functions.linearize_constraints, Rail)
@kernel
def _linearize_constraints(rail: Rail, x: Array, h: Array, jacobian: Array) -> None:
    h[0] = x[0] - rail.wall
    h[1] = x[1] - rail.speed_limit
    jacobian[:, :] = 0.0
    jacobian[0, 0] = 1.0
    jacobian[1, 1] = 1.0
