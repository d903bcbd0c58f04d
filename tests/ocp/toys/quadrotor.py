"""A quadrotor through a round gate; state [position, velocity, Euler angles ZYX], input [thrust by mass, body rates]."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from toy import Toy, runge_kutta

from doorman.compilation import kernel
from doorman.ocp import Bounds, Problem, QuadraticCost, functions

Array = NDArray[np.float64]

GRAVITY = 9.81
TILT = 0.7
"""Largest roll and pitch [rad]."""


class Quadrotor(NamedTuple):
    """Numbers of the kernels."""

    time_step: float
    gate: Array
    """Centre of the gate [m], its normal is x, shape (3,)."""
    radius: float
    """Room for the vehicle's centre in the gate's plane [m]."""
    funnel: float
    """How fast the room widens before and behind the gate."""
    rates: Array
    """Memory of a step, shape (4, 9)."""
    between: Array
    """Shape (9,)."""


@kernel
def _rate(x: Array, u: Array, out: Array) -> None:
    roll, pitch, yaw = x[6], x[7], x[8]
    sr, cr, sp, cp, sy, cy = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch), np.sin(yaw), np.cos(yaw)
    for i in range(3):
        out[i] = x[3 + i]
    out[3] = u[0] * (cy * sp * cr + sy * sr)
    out[4] = u[0] * (sy * sp * cr - cy * sr)
    out[5] = u[0] * cp * cr - GRAVITY
    turn = u[2] * sr + u[3] * cr
    out[6] = u[1] + turn * sp / cp
    out[7] = u[2] * cr - u[3] * sr
    out[8] = turn / cp


@functions.implement(functions.step, Quadrotor)
@kernel
def _step(model: Quadrotor, x: Array, u: Array, out: Array) -> None:
    dt, k, between = model.time_step, model.rates, model.between
    _rate(x, u, k[0])
    for stage in range(1, 4):
        for i in range(9):
            between[i] = x[i] + (dt if stage == 3 else 0.5 * dt) * k[stage - 1, i]
        _rate(between, u, k[stage])
    for i in range(9):
        out[i] = x[i] + dt / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])


@functions.implement(functions.constrain, Quadrotor)
@kernel
def _constrain(model: Quadrotor, x: Array, h: Array) -> None:
    along, aside, above = x[0] - model.gate[0], x[1] - model.gate[1], x[2] - model.gate[2]
    h[0] = aside * aside + above * above - model.radius**2 - model.funnel * along * along


def quadrotor(horizon: int = 50, dt: float = 0.04) -> Toy:
    """From hover on one side to hover on the other; the straight way misses the gate by far."""
    gate, radius, funnel = np.array([1.5, 0.8, 1.5]), 0.3, 1.0
    cost = QuadraticCost(
        state_weights=[1.0, 1.0, 1.0, 0.1, 0.1, 0.1, 0.5, 0.5, 0.5],
        terminal_weights=[50.0, 50.0, 50.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0], input_weights=[0.02, 0.1, 0.1, 0.1],
        state_goal=[3.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], input_goal=[GRAVITY, 0.0, 0.0, 0.0],
    )  # fmt: skip
    problem = Problem(
        Quadrotor(dt, gate, radius, funnel, np.zeros((4, 9)), np.zeros(9)), horizon=horizon, time_step=dt, cost=cost,
        n_constraints=1, constraint_names=("gate",),
        bounds=Bounds(
            state_lower=[*[-np.inf] * 6, -TILT, -TILT, -np.inf], state_upper=[*[np.inf] * 6, TILT, TILT, np.inf],
            input_lower=[2.0, -3.0, -3.0, -3.0], input_upper=[18.0, 3.0, 3.0, 3.0],
        ),
    )  # fmt: skip

    def rate(x: ca.SX, u: ca.SX) -> ca.SX:
        (sr, sp, sy), (cr, cp, cy) = ([f(x[6 + i]) for i in range(3)] for f in (ca.sin, ca.cos))
        about_x = ca.blockcat([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        about_y = ca.blockcat([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        about_z = ca.blockcat([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        upward = (about_z @ about_y @ about_x)[:, 2]
        euler_rates = ca.blockcat([[1, sr * sp / cp, cr * sp / cp], [0, cr, -sr], [0, sr / cp, cr / cp]])
        return ca.vertcat(x[3:6], u[0] * upward - ca.DM([0, 0, GRAVITY]), euler_rates @ u[1:4])

    def rows(x: ca.SX) -> ca.SX:
        offset = x[:3] - gate
        return offset[1] ** 2 + offset[2] ** 2 - radius**2 - funnel * offset[0] ** 2

    return Toy(problem, np.array([0.0, 0.0, 1.0, *[0.0] * 6]), runge_kutta(rate, dt), rows)
