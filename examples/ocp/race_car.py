"""Race a small car along a track, in coordinates of the track's middle line (Frenet frame).

State: progress along the middle line [m], place across it [m], heading from it [rad], speed [m/s], throttle, steering angle
[rad]. Inputs: rates of throttle [1/s] and steering [rad/s].
Car, limits and weights are those of Kloeser, Schöls, Sartor, Zanelli, Frison and Diehl, "NMPC for racing using a singularity-free
path-parametric model with obstacle avoidance", IFAC 2020, as in acados' example "race_cars"; the track is ours.
"""

from typing import Any

import casadi as ca
import numpy as np
from example import Example

from doorman import ocp

MASS, C1, C2 = 0.043, 0.5, 15.5  # kg, -, 1/m: slip and yaw of the steering
CM1, CM2, CR0, CR2 = 0.28, 0.05, 0.011, 0.006  # N, N s/m, N, N s²/m²: motor and resistance
LENGTH, LOOK_AHEAD, HORIZON, TIME_STEP = 8.71, 3.0, 50, 0.02  # m, m, steps, s
EVERY_NODE = np.linspace(0.0, LOOK_AHEAD, HORIZON + 1)

x, u, wanted = ca.SX.sym("x", 6), ca.SX.sym("u", 2), ca.SX.sym("wanted")
progress, across, heading, speed, throttle, steering = ca.vertsplit(x)


def curvature(s: Any, cos: Any) -> Any:
    """Of the middle line [1/m]: one turn in two equal halves, so that it closes."""
    turn = 2 * np.pi / LENGTH
    return turn * (1.0 + 1.5 * cos(2 * turn * s) - 1.6 * cos(4 * turn * s))


push = (CM1 - CM2 * speed) * throttle - CR2 * speed**2 - CR0 * ca.tanh(5 * speed)  # N
kappa = curvature(progress, ca.cos)
advance = speed * ca.cos(heading + C1 * steering) / (1 - kappa * across)
rate = ca.vertcat(
    advance, speed * ca.sin(heading + C1 * steering), speed * C2 * steering - kappa * advance,
    push / MASS * ca.cos(C1 * steering), u,
)  # fmt: skip
along = push / MASS
sideways = C2 * speed**2 * steering + push / MASS * ca.sin(C1 * steering)
cost = ocp.QuadraticCost(
    state_weights=[0.0, 1e-8, 1e-8, 1e-8, 1e-3, 5e-3], terminal_weights=[0.0, 10.0, 1e-8, 1e-8, 5e-3, 2e-3],
    input_weights=[1e-3, 5e-3], state_goal=[0.0] * 6, input_goal=[0.0, 0.0],
)  # fmt: skip


def ahead(state: np.ndarray) -> np.ndarray:
    """Progress that is wanted at every node: farther than the car can drive."""
    return np.reshape(state[0] + EVERY_NODE, (-1, 1))


def drive(state: np.ndarray) -> np.ndarray:
    """Where a car of 1 m/s is at the end of the horizon."""
    return np.array([state[0] + HORIZON * TIME_STEP, 0.0, 0.0, 1.0, 0.0, 0.0])


def one_lap(states: np.ndarray) -> bool:
    """Whether the car has driven once around, on the track."""
    return bool(states[-1, 0] - states[0, 0] > LENGTH and np.abs(states[1:, 1]).max() < 0.125)


def draw(axes: Any, states: np.ndarray) -> None:
    """Track and path."""
    s = np.linspace(0.0, LENGTH, 2001)
    direction = np.concatenate([[0.0], np.cumsum(curvature(s, np.cos)[:-1] * np.diff(s))])
    middle = np.concatenate([[0.0], np.cumsum(np.exp(1j * direction[:-1]) * np.diff(s))])
    for side in (-0.12, 0.12):
        edge = middle + 1j * side * np.exp(1j * direction)
        axes.plot(edge.real, edge.imag, color="#D55E00")
    at = np.searchsorted(s, states[:, 0] % LENGTH)
    path = middle[at] + 1j * states[:, 1] * np.exp(1j * direction[at])
    axes.plot(path.real, path.imag)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


EXAMPLE = Example(
    name="race car", source="Kloeser et al. 2020, and acados, race_cars",
    model=ocp.SymbolicModel(x, u, rate, node_parameters=wanted, steps=2), rate=rate,
    horizon=HORIZON, time_step=TIME_STEP, cost=cost, node_parameters=ahead, end=drive,
    bounds=ocp.Bounds(
        state_lower=[-np.inf, -0.12, -np.inf, -np.inf, -1.0, -0.4],
        state_upper=[np.inf, 0.12, np.inf, np.inf, 1.0, 0.4], input_lower=[-10.0, -2.0], input_upper=[10.0, 2.0],
    ),
    constraints=[
        ocp.Constraint("along", along, unit="m/s²", lower=-4.0, upper=4.0),
        ocp.Constraint("sideways", sideways, unit="m/s²", lower=-4.0, upper=4.0),
    ],
    costs=[
        ocp.Residual("progress", progress - wanted, 0.1), ocp.Residual("distance", progress - wanted, 5.0, at="end")
    ],
    start=[0.0, 0.0, 0.0, 1.0, 0.2, 0.0], spread=[4.0, 0.08, 0.2, 0.5, 0.2, 0.05],
    steps=400, noise=[1e-4, 1e-4, 1e-3, 2e-3, 0.0, 0.0], reached=one_lap, draw=draw,
)  # fmt: skip

if __name__ == "__main__":
    EXAMPLE.main()
