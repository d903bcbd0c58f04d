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
