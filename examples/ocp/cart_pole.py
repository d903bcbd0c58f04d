"""Swing a pole up by pushing the cart that it hangs on.

State: position of the cart [m], angle of the pole from upright [rad], their rates. Input: force on the cart [N].
Dynamics, weights and limit are those of acados' example "pendulum_on_cart" (https://docs.acados.org).
"""

from typing import Any

import casadi as ca
import numpy as np
from example import Example

from doorman import ocp

CART, BOB, LENGTH, GRAVITY, FORCE = 1.0, 0.1, 0.8, 9.81, 80.0  # kg, kg, m, m/s², N

x, u = ca.SX.sym("x", 4), ca.SX.sym("u")
_, angle, velocity, turning = ca.vertsplit(x)
sine, cosine = ca.sin(angle), ca.cos(angle)

pull = BOB * sine * (GRAVITY * cosine - LENGTH * turning**2)
moved = CART + BOB * sine**2
spin = (u * cosine - BOB * LENGTH * sine * cosine * turning**2 + (CART + BOB) * GRAVITY * sine) / (LENGTH * moved)
rate = ca.vertcat(velocity, turning, (u + pull) / moved, spin)

weights = [2e3, 2e3, 2e-2, 2e-2]
cost = ocp.QuadraticCost(
    state_weights=weights, terminal_weights=weights, input_weights=[2e-2],
    state_goal=[0.0] * 4, input_goal=[0.0],
)  # fmt: skip


def upright(states: np.ndarray) -> bool:
    """Whether the pole stands over the place where it should; the disturbance keeps it in motion."""
    upward = 2 * np.pi * round(states[-1, 1] / (2 * np.pi))
    return bool((np.abs(states[-1] - [0.0, upward, 0.0, 0.0]) < [0.1, 0.1, 0.5, 0.5]).all())


def draw(axes: Any, states: np.ndarray) -> None:
    """The bob's path."""
    axes.plot(states[:, 0] - LENGTH * np.sin(states[:, 1]), LENGTH * np.cos(states[:, 1]), "o-", markersize=3)
    axes.set(xlabel="across [m]", ylabel="up [m]", aspect="equal")


EXAMPLE = Example(
    name="pendulum on a cart", source="acados, pendulum_on_cart",
    model=ocp.SymbolicModel(x, u, rate), rate=rate, horizon=50, time_step=0.04,
    cost=cost, bounds=ocp.Bounds(input_lower=[-FORCE], input_upper=[FORCE]),
    start=[0.0, np.pi, 0.0, 0.0], spread=[0.5, 0.5, 0.5, 0.5],
    steps=100, noise=[1e-3, 1e-3, 1e-2, 1e-2], reached=upright, draw=draw,
)  # fmt: skip

if __name__ == "__main__":
    EXAMPLE.main()
