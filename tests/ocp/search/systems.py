"""Systems on which the search has something to find: more than one local minimum, or unstable."""

from __future__ import annotations

import casadi as ca
import numpy as np
from system import System

from doorman import ocp


def cart_pole() -> System:
    """A pole on a cart, to be swung up: acados' example."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u")
    cart, pole, length, gravity = 1.0, 0.1, 0.8, 9.81
    angle, speed, turn = x[1], x[2], x[3]
    sine, cosine = ca.sin(angle), ca.cos(angle)
    mass = cart + pole - pole * cosine**2
    acceleration = (-pole * length * sine * turn**2 + pole * gravity * cosine * sine + u) / mass
    swing = -pole * length * cosine * sine * turn**2 + u * cosine + (cart + pole) * gravity * sine
    weights = 2.0 * np.array([1e3, 1e3, 1e-2, 1e-2])
    return System(
        x, u, ca.vertcat(speed, turn, acceleration, swing / (length * mass)), 50, 0.04,
        ocp.QuadraticCost(weights, weights, [2e-2], np.zeros(4), [0.0]), [0.0, np.pi, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5],
        bounds=ocp.Bounds(input_lower=[-80.0], input_upper=[80.0]),
    )  # fmt: skip


def parking() -> System:
    """A car of one axle that has to stand in a place exactly, with full weights and every kind of row that has two ends."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 3)  # place, heading, speed; turn, acceleration, load
    rate = ca.vertcat(x[3] * ca.cos(x[2]), x[3] * ca.sin(x[2]), u[0], u[1])
    state = np.diag([0.5, 0.5, 0.1, 0.2])
    state[0, 1] = state[1, 0] = 0.2
    inputs = np.array([[0.3, 0.1, 0.0], [0.1, 0.2, 0.05], [0.0, 0.05, 0.4]])
    cross = np.zeros((3, 4))
    cross[1, 3] = 0.1
    return System(
        x, u, rate, 30, 0.1,
        ocp.QuadraticCost(state, 2.0 * state, inputs, [2.0, 1.0, 0.0, 0.0], [0.0] * 3, cross_weights=cross),
        [0.0, 0.0, 0.3, 0.2], [0.3, 0.3, 0.3, 0.2],
        bounds=ocp.Bounds(input_lower=[-3.0, -2.0, -np.inf], input_upper=[3.0, 2.0, np.inf]),
        constraints=(
            ocp.Constraint("place", x[0], equals=2.0, unit="m", at="end"),
            ocp.Constraint("lane", x[1], equals=1.0, unit="m", scale=2.0, at="end"),
            ocp.Constraint("stand", x[2:], equals=0.0, at="end"),
            ocp.Constraint("grip", u[0] * x[3], lower=-0.9, upper=0.7, unit="m/s²"),
            ocp.Constraint("speed", x[3], lower=-0.4, upper=1.1, unit="m/s"),
            ocp.Constraint("load", u[2] - u[1] * (0.5 + x[3]) - 0.3 * u[0] * x[3], equals=0.1, scale=0.5, unit="N"),
        ),
    )  # fmt: skip
