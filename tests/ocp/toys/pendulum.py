"""The tutorial's pendulum, swung up beside a wall; state [angle from hanging, rate], input the torque."""

from __future__ import annotations

import casadi as ca
import numpy as np
from toy import Toy
from tutorial import tutorial


def pendulum() -> Toy:
    """From hanging to leaning on the wall, with a motor too weak to hold the bob sideways."""
    problem = tutorial().pendulum

    def advance(x: ca.SX, u: ca.SX) -> ca.SX:
        def rate(x: ca.SX) -> ca.SX:
            return ca.vertcat(x[1], u[0] - 9.81 * ca.sin(x[0]) - 0.1 * x[1])

        a = rate(x)
        b = rate(x + 0.025 * a)
        c = rate(x + 0.025 * b)
        return x + 0.05 / 6 * (a + 2 * b + 2 * c + rate(x + 0.05 * c))

    return Toy(problem, np.zeros(2), advance, lambda x: -ca.sin(x[0]) - 0.1)
