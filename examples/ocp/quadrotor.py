"""Fly a quadrotor around two pillars.

State: position [m], velocity [m/s] in the world; roll, pitch, yaw [rad]; rates in the body [rad/s]. Inputs: thrusts of the rotors
[N]. The vehicle, its rotors and the task are those of the quadrotor examples of crocoddyl and of aligator
("quadrotor_obstacles", https://github.com/Simple-Robotics/aligator); the pillars stand elsewhere.
"""

from typing import Any

import casadi as ca
import numpy as np
from example import Example

from doorman import ocp

MASS, INERTIA = 1.477, [0.01152, 0.01152, 0.0218]  # kg, kg m²
ARM, SPIN, THRUST = 0.1525, 1e-6 / 6.6e-5, 5.0  # m, m, N: of a rotor
TILT = 1.2  # of roll and pitch: Euler angles have a pole at π/2 [rad]
PILLARS, CLEARANCE = [(-0.15, 0.8), (0.35, 1.7)], 0.5  # centres, radius of pillar and vehicle [m]

x, u = ca.SX.sym("x", 12), ca.SX.sym("u", 4)
position, velocity, attitude, rates = x[:3], x[3:6], x[6:9], x[9:]
roll, pitch, yaw = ca.vertsplit(attitude)
cr, sr, cp, sp, cy, sy = (f(angle) for angle in (roll, pitch, yaw) for f in (ca.cos, ca.sin))

thrust_axis = ca.vertcat(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr)
euler_rates = ca.vertcat(
    rates[0] + sp / cp * (sr * rates[1] + cr * rates[2]), cr * rates[1] - sr * rates[2],
    (sr * rates[1] + cr * rates[2]) / cp,
)  # fmt: skip
torque = ca.vertcat(ARM * (u[1] - u[3]), ARM * (u[2] - u[0]), SPIN * (u[1] + u[3] - u[0] - u[2]))
spin_up = (torque - ca.cross(rates, ca.DM(INERTIA) * rates)) / ca.DM(INERTIA)
rate = ca.vertcat(velocity, ca.sum1(u) / MASS * thrust_axis - ca.vertcat(0, 0, 9.81), euler_rates, spin_up)

goal = [0.3, 2.5, 1.0, *[0.0] * 9]
cost = ocp.QuadraticCost(
    state_weights=[1.0] * 3 + [0.1] * 3 + [0.1] * 3 + [0.01] * 3,
    terminal_weights=[50.0] * 3 + [5.0] * 3 + [5.0] * 3 + [0.5] * 3, input_weights=[0.02] * 4,
    state_goal=goal, input_goal=[MASS * 9.81 / 4] * 4,
)  # fmt: skip
pillars = [
    ocp.Constraint(f"pillar {i}", CLEARANCE**2 - (x[0] - across) ** 2 - (x[1] - along) ** 2, unit="m²")
    for i, (across, along) in enumerate(PILLARS)
]


def arrived(states: np.ndarray) -> bool:
    """Whether it hovers at the goal."""
    return bool(np.abs(states[-1, :6] - goal[:6]).max() < 0.1)


def draw(axes: Any, states: np.ndarray) -> None:
    """Path from above, and pillars with their clearance."""
    turn = np.linspace(0.0, 2 * np.pi, 100)
    for across, along in PILLARS:
        axes.fill(across + CLEARANCE * np.cos(turn), along + CLEARANCE * np.sin(turn), color="#D55E00", alpha=0.5)
    axes.plot(*states[:, :2].T, "o-", markersize=3)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


EXAMPLE = Example(
    name="quadrotor around pillars", source="crocoddyl and aligator, quadrotor",
    model=ocp.SymbolicModel(x, u, rate), rate=rate, horizon=60, time_step=0.05,
    cost=cost, bounds=ocp.Bounds(
        state_lower=[-np.inf] * 6 + [-TILT] * 2 + [-np.inf] * 4, state_upper=[np.inf] * 6 + [TILT] * 2 + [np.inf] * 4,
        input_lower=[0.1] * 4, input_upper=[THRUST] * 4,
    ), constraints=pillars,
    start=[-0.3, -0.5, 0.5, *[0.0] * 9], spread=[0.4, 0.3, 0.3, *[0.3] * 3, *[0.2] * 3, *[0.3] * 3],
    steps=120, noise=[1e-3] * 3 + [5e-3] * 3 + [2e-3] * 3 + [1e-2] * 3, reached=arrived, draw=draw,
)  # fmt: skip

if __name__ == "__main__":
    EXAMPLE.main()
