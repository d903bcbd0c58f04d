"""Swing a pendulum up beside a wall: an optimal control problem of plain Python functions, then a controller that follows it."""

import numpy as np

from doorman import DoormanError
from doorman.ocp import Bounds, Hybrid, PythonModel, QuadraticCost, runge_kutta

TIME_STEP, HORIZON, WALL, TORQUE = 0.05, 60, 0.1, 8.0  # s, steps, m, N m


def swing(x: np.ndarray, u: np.ndarray, friction: float = 0.1) -> list[float]:
    """Rate of [angle from hanging, angular rate] of 1 kg on a rod of 1 m."""
    return [x[1], u[0] - 9.81 * np.sin(x[0]) - friction * x[1]]


def beside_the_wall(x: np.ndarray) -> float:
    """How far the bob is inside the wall, which is to be negative [m]."""
    inside: float = -np.sin(x[0]) - WALL
    return inside


cost = QuadraticCost(
    state_weights=[1.0, 0.1], terminal_weights=[100.0, 10.0], input_weights=[0.02],
    state_goal=[np.pi, 0.0], input_goal=[0.0],
)  # fmt: skip
model = PythonModel(runge_kutta(swing, TIME_STEP), constraints=beside_the_wall, derivatives="complex step")
motor = Bounds(input_lower=[-TORQUE], input_upper=[TORQUE])
try:
    solver = Hybrid(model.problem(cost, HORIZON, TIME_STEP, bounds=motor, constraint_names=["wall"]))
    plan = solver.solve([0.0, 0.0])
except DoormanError as error:
    raise SystemExit(f"cannot be solved: {error}") from error
print(plan.message())
if not plan.usable:
    raise SystemExit("there is no plan to follow")

stiffer = runge_kutta(lambda x, u: swing(x, u, friction=0.2), TIME_STEP)  # the real one: twice the friction
state, worst = np.zeros(2), -np.inf
for k in range(HORIZON):
    torque = plan.inputs[k] + plan.gains[k] @ (state - plan.states[k])
    state = stiffer(state, np.clip(torque, -TORQUE, TORQUE))
    worst = max(worst, beside_the_wall(state))
print(f"the pendulum ended at {np.degrees(state[0]):.1f}°, wanted 180°")
print(f"it stayed {-worst:.2f} m clear of the wall")
