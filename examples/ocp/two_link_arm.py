"""Reach a place with a two-link arm that must not touch a wall.

State: angles of shoulder and elbow [rad], their rates. Inputs: torques [N m]. The arm moves in a horizontal plane.
Dynamics and the numbers of a human arm are those of Li and Todorov, "Iterative linear quadratic regulator design for nonlinear
biological movement systems", ICINCO 2004; wall and limits are ours.
"""

from typing import Any

import casadi as ca
import numpy as np
from example import Example

from doorman import ocp

UPPER, LOWER = 0.30, 0.33  # lengths [m]
WALL, TORQUE = 0.42, 6.0  # m, N m
TARGET = [-0.25, 0.40]  # m
I1, I2, M2, S2 = 0.025, 0.045, 1.0, 0.16  # inertias [kg m²], mass of the lower arm [kg], its centre [m]
FRICTION = ca.DM([[0.05, 0.025], [0.025, 0.05]])  # N m s/rad

x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
angles, rates = x[:2], x[2:]
coupling = M2 * UPPER * S2 * ca.cos(angles[1])
a1 = I1 + I2 + M2 * UPPER**2 + 2 * coupling
inertia = ca.vertcat(ca.horzcat(a1, I2 + coupling), ca.horzcat(I2 + coupling, I2))
whirl = M2 * UPPER * S2 * ca.sin(angles[1]) * ca.vertcat(-rates[1] * (2 * rates[0] + rates[1]), rates[0] ** 2)
rate = ca.vertcat(rates, ca.inv(inertia) @ (u - whirl - FRICTION @ rates))


def tip(shoulder: Any, elbow: Any, cos: Any = np.cos, sin: Any = np.sin) -> tuple[Any, Any]:
    """Place of the tip [m]."""
    both = shoulder + elbow
    return UPPER * cos(shoulder) + LOWER * cos(both), UPPER * sin(shoulder) + LOWER * sin(both)


place = ca.vertcat(*tip(angles[0], angles[1], ca.cos, ca.sin))
calm = ocp.QuadraticCost(
    state_weights=[0.0, 0.0, 0.05, 0.05], terminal_weights=[0.0, 0.0, 1.0, 1.0], input_weights=[0.01, 0.01],
    state_goal=[1.8, 1.5, 0.0, 0.0], input_goal=[0.0, 0.0],
)  # fmt: skip
reach = place - ca.DM(TARGET)


def at_target(states: np.ndarray) -> bool:
    """Whether the tip rests at the target."""
    apart = np.hypot(*(np.array(tip(*states[-1, :2])) - TARGET))
    return bool(apart < 0.02 and np.abs(states[-1, 2:]).max() < 0.1)


def draw(axes: Any, states: np.ndarray) -> None:
    """Path of the tip, and the wall."""
    axes.plot(*tip(*states[:, :2].T), "o-", markersize=3)
    axes.axhline(WALL, color="#D55E00")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


EXAMPLE = Example(
    name="two-link arm", source="Li and Todorov 2004",
    model=ocp.SymbolicModel(x, u, rate), rate=rate, horizon=50, time_step=0.02, cost=calm,
    bounds=ocp.Bounds([-0.6, 0.0, -12.0, -12.0], [2.8, 2.7, 12.0, 12.0], [-TORQUE] * 2, [TORQUE] * 2),
    constraints=[ocp.Constraint("wall", place[1] - WALL, unit="m")],
    costs=[ocp.Residual("reach", reach, 20.0), ocp.Residual("arrive", reach, 200.0, at="end")],
    start=[-0.1, 0.9, 0.0, 0.0], spread=[0.2, 0.3, 0.5, 0.5],
    steps=100, noise=[1e-4, 1e-4, 5e-3, 5e-3], reached=at_target, draw=draw,
)  # fmt: skip

if __name__ == "__main__":
    EXAMPLE.main()
