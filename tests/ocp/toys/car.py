"""A car between two round obstacles; state [x, y, heading, speed], input [acceleration, steering angle]."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from toy import Toy, runge_kutta

from doorman.compilation import kernel
from doorman.ocp import Bounds, Problem, QuadraticCost, functions

Array = NDArray[np.float64]

WHEELBASE = 1.0


class Car(NamedTuple):
    """Kinematic bicycle."""

    time_step: float
    obstacles: Array
    """x, y and radius of each, shape (2, 3)."""
    rates: Array
    """Memory of a step, shape (4, 4)."""
    between: Array
    """Shape (4,)."""


@kernel
def _rate(x: Array, u: Array, out: Array) -> None:
    out[0] = x[3] * np.cos(x[2])
    out[1] = x[3] * np.sin(x[2])
    out[2] = x[3] * np.tan(u[1]) / WHEELBASE
    out[3] = u[0]


@functions.implement(functions.step, Car)
@kernel
def _step(model: Car, x: Array, u: Array, out: Array) -> None:
    dt, k, between = model.time_step, model.rates, model.between
    _rate(x, u, k[0])
    for stage in range(1, 4):
        for i in range(4):
            between[i] = x[i] + (dt if stage == 3 else 0.5 * dt) * k[stage - 1, i]
        _rate(between, u, k[stage])
    for i in range(4):
        out[i] = x[i] + dt / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])


@functions.implement(functions.constrain, Car)
@kernel
def _constrain(model: Car, x: Array, h: Array) -> None:
    for i in range(2):
        a, b, radius = model.obstacles[i, 0], model.obstacles[i, 1], model.obstacles[i, 2]
        h[i] = radius - np.sqrt((x[0] - a) ** 2 + (x[1] - b) ** 2)


def car(horizon: int = 60, dt: float = 0.1) -> Toy:
    """From standstill to a parking place behind the obstacles; the straight way leads through both."""
    obstacles = np.array([[3.0, -0.4, 1.0], [6.0, 0.6, 1.0]])
    cost = QuadraticCost(
        state_weights=[0.5, 0.5, 0.1, 0.1], terminal_weights=[50.0, 50.0, 20.0, 20.0], input_weights=[0.5, 1.0],
        state_goal=[9.0, 0.0, 0.0, 0.0], input_goal=[0.0, 0.0],
    )  # fmt: skip
    problem = Problem(
        Car(dt, obstacles, np.zeros((4, 4)), np.zeros(4)), horizon=horizon, time_step=dt, cost=cost, n_constraints=2,
        bounds=Bounds(input_lower=[-2.0, -0.5], input_upper=[2.0, 0.5], state_upper=[np.inf, np.inf, np.inf, 3.0]),
        constraint_names=("first obstacle", "second obstacle"),
    )  # fmt: skip

    def rate(x: ca.SX, u: ca.SX) -> ca.SX:
        return ca.vertcat(x[3] * ca.cos(x[2]), x[3] * ca.sin(x[2]), x[3] * ca.tan(u[1]) / WHEELBASE, u[0])

    def rows(x: ca.SX) -> ca.SX:
        return ca.vertcat(*(r - ca.sqrt((x[0] - a) ** 2 + (x[1] - b) ** 2) for a, b, r in obstacles))

    return Toy(problem, np.zeros(4), runge_kutta(rate, dt), rows)
