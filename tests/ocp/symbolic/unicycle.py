"""A unicycle that passes a moving obstacle: every kind of term that a symbolic problem is made of, and IPOPT's solution of it."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from doorman import ocp

Array = NDArray[np.float64]

HORIZON, TIME_STEP, START = 40, 0.1, np.array([0.0, 0.0, 0.0])
PARAMETERS = np.array([0.5, 2.0])
"""Radius of the obstacle [m], weight of the end's residual."""

x, u = ca.SX.sym("x", 3), ca.SX.sym("u", 2)
p, q = ca.SX.sym("p", 2), ca.SX.sym("q", 3)
RATE = ca.vertcat(u[0] * ca.cos(x[2]), u[0] * ca.sin(x[2]), u[1])
OBSTACLE = p[0] - ca.sqrt((x[0] - q[0]) ** 2 + (x[1] - q[1]) ** 2 + 1e-6)
WHEELS = ca.vertcat(u[0] + 0.3 * u[1] - 1.5, u[0] - 0.3 * u[1] - 1.5)
GATE = x[1] - 1.0
LANE = 0.5 * (x[1] - q[2]) ** 2 + 0.1 * (1.0 - ca.cos(x[2]))
HASTE = 0.05 * ca.exp(-u[0])
ARRIVAL = ca.vertcat(x[0] - 3.0, x[1] - 0.8)


def nodes(speed: float = 0.3, first: int = 0) -> Array:
    """Obstacle's place and reference of y at nodes from a first one on, shape (N + 1, 3)."""
    time = TIME_STEP * np.arange(first, first + HORIZON + 1)
    return np.stack([1.5 - speed * time, 0.1 + 0.05 * time, 0.6 * np.ones_like(time)], axis=1)


def problem() -> ocp.Problem:
    """The problem."""
    model = ocp.SymbolicModel(x, u, RATE, parameters=p, node_parameters=q, steps=2)
    return model.problem(
        horizon=HORIZON, time_step=TIME_STEP, parameters=PARAMETERS, node_parameters=nodes(),
        cost=ocp.QuadraticCost([0.1, 0.0, 0.0], [1.0, 0.0, 0.2], [0.2, 0.1], [3.0, 0.0, 0.0], [0.0, 0.0]),
        bounds=ocp.Bounds(input_lower=[-0.2, -2.0], input_upper=[1.3, 2.0]),
        constraints=[
            ocp.Constraint("obstacle", OBSTACLE, unit="m", scale=2.0),
            ocp.Constraint("wheel", WHEELS, unit="m/s"),
            ocp.Constraint("gate", GATE, unit="m", at="end"),
        ],
        costs=[
            ocp.Cost("lane", LANE, hessian="positive"),
            ocp.Cost("haste", HASTE),
            ocp.Residual("arrival", ARRIVAL, weights=p[1], at="end"),
        ],
    )  # fmt: skip


def step(state: ca.SX, inputs: ca.SX) -> ca.SX:
    """x⁺, two steps of RK4 written out."""
    rate, h = ca.Function("rate", [x, u], [RATE]), TIME_STEP / 2
    for _ in range(2):
        a = rate(state, inputs)
        b = rate(state + h / 2 * a, inputs)
        c = rate(state + h / 2 * b, inputs)
        d = rate(state + h * c, inputs)
        state = state + h / 6 * (a + 2 * b + 2 * c + d)
    return state


def cost(states: ca.SX, inputs: ca.SX, parameters: Array, at: Array) -> ca.SX:
    """J of columns of states and inputs, written out."""
    extra = ca.Function("extra", [x, u, q], [LANE + HASTE])
    total = ca.SX(0)
    for k in range(HORIZON):
        s, i = states[:, k], inputs[:, k]
        total += TIME_STEP * (0.05 * (s[0] - 3.0) ** 2 + 0.1 * i[0] ** 2 + 0.05 * i[1] ** 2 + extra(s, i, at[k]))
    s = states[:, HORIZON]
    total += 0.5 * (s[0] - 3.0) ** 2 + 0.1 * s[2] ** 2
    return total + 0.5 * parameters[1] * ((s[0] - 3.0) ** 2 + (s[1] - 0.8) ** 2)


def ipopt(
    guess: tuple[Array, Array], parameters: Array = PARAMETERS, at: Array | None = None, start: Array = START
) -> tuple[float, Array]:
    """Optimal cost and states by multiple shooting, from states (N + 1, 3) and inputs (N, 2)."""
    at = nodes() if at is None else at
    states, inputs = ca.SX.sym("X", 3, HORIZON + 1), ca.SX.sym("U", 2, HORIZON)
    rows = ca.Function("rows", [x, p, q], [OBSTACLE])
    equal = [states[:, 0] - start] + [states[:, k + 1] - step(states[:, k], inputs[:, k]) for k in range(HORIZON)]
    unequal = [rows(states[:, k + 1], parameters, at[k + 1]) for k in range(HORIZON)]
    unequal += [ca.substitute(WHEELS, u, inputs[:, k]) for k in range(HORIZON)]
    unequal += [states[1, HORIZON] - 1.0]
    equal, unequal = ca.vertcat(*equal), ca.vertcat(*unequal)
    variables = ca.vertcat(ca.vec(states), ca.vec(inputs))
    nlp = {"x": variables, "f": cost(states, inputs, parameters, at), "g": ca.vertcat(equal, unequal)}
    solver = ca.nlpsol("ipopt", "ipopt", nlp, {"ipopt.print_level": 0, "print_time": 0, "ipopt.tol": 1e-10})
    size = 3 * (HORIZON + 1)
    lower = np.concatenate([np.full(size, -np.inf), np.tile([-0.2, -2.0], HORIZON)])
    upper = np.concatenate([np.full(size, np.inf), np.tile([1.3, 2.0], HORIZON)])
    first = np.concatenate([guess[0].ravel(), guess[1].ravel()])
    found = solver(
        x0=first, lbx=lower, ubx=upper, ubg=0.0,
        lbg=np.concatenate([np.zeros(equal.numel()), np.full(unequal.numel(), -np.inf)]),
    )  # fmt: skip
    assert solver.stats()["success"]
    return float(found["f"]), np.array(found["x"][:size]).reshape(HORIZON + 1, 3)
