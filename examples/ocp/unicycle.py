"""Drive a unicycle to a place between round obstacles.

State: place [m] and heading [rad]. Inputs: speed [m/s] and yaw rate [rad/s].
The unicycle is that of crocoddyl's introductory notebook (https://github.com/loco-3d/crocoddyl); obstacles and limits are ours.
"""

from typing import Any

import casadi as ca
import numpy as np
from example import Example

from doorman import ocp

OBSTACLES = [(1.0, 0.15, 0.4), (1.9, -0.5, 0.35), (2.1, 0.7, 0.45)]  # centre and radius [m]

x, u = ca.SX.sym("x", 3), ca.SX.sym("u", 2)
rate = ca.vertcat(u[0] * ca.cos(x[2]), u[0] * ca.sin(x[2]), u[1])

cost = ocp.QuadraticCost(
    state_weights=[1.0, 1.0, 0.1], terminal_weights=[50.0, 50.0, 5.0], input_weights=[0.2, 0.1],
    state_goal=[3.0, 0.0, 0.0], input_goal=[0.0, 0.0],
)  # fmt: skip
obstacles = [
    ocp.Constraint(f"obstacle {i}", radius**2 - (x[0] - across) ** 2 - (x[1] - up) ** 2, unit="m²")
    for i, (across, up, radius) in enumerate(OBSTACLES)
]


def arrived(states: np.ndarray) -> bool:
    """Whether it stands at the goal, as straight as the disturbance allows."""
    return bool((np.abs(states[-1] - [3.0, 0.0, 0.0]) < [0.1, 0.1, 0.3]).all())


def draw(axes: Any, states: np.ndarray) -> None:
    """Path and obstacles."""
    turn = np.linspace(0.0, 2 * np.pi, 100)
    for across, up, radius in OBSTACLES:
        axes.fill(across + radius * np.cos(turn), up + radius * np.sin(turn), color="#D55E00")
    axes.plot(*states[:, :2].T, "o-", markersize=3)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


EXAMPLE = Example(
    name="unicycle with obstacles", source="crocoddyl, unicycle",
    model=ocp.SymbolicModel(x, u, rate), rate=rate, horizon=50, time_step=0.1,
    cost=cost, bounds=ocp.Bounds(input_lower=[-0.5, -2.0], input_upper=[1.5, 2.0]), constraints=obstacles,
    start=[0.0, 0.0, 0.0], spread=[0.3, 0.5, 0.8],
    steps=100, noise=[2e-3, 2e-3, 5e-3], reached=arrived, draw=draw,
)  # fmt: skip

if __name__ == "__main__":
    EXAMPLE.main()
