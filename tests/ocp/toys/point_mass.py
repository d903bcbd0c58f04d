"""A cart with a limit on its speed: linear and quadratic, so that one dense quadratic program solves it."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from proxsuite import proxqp
from toy import Reference, Toy

from doorman.ocp import Bounds, PythonModel, QuadraticCost

Array = NDArray[np.float64]

DT = 0.1
DYNAMICS = np.array([[1.0, DT], [0.0, 1.0]])
PUSH = np.array([[0.5 * DT**2], [DT]])
SPEED, FORCE = 0.5, 1.0


def point_mass() -> Toy:
    """From rest to rest, with the speed and the force at their limits on the way."""

    def advance(x: ca.SX, u: ca.SX) -> ca.SX:
        return ca.mtimes(DYNAMICS, x) + ca.mtimes(PUSH, u)

    model = PythonModel(lambda x, u: DYNAMICS @ x + PUSH @ u, constraints=lambda x: x[1] - SPEED)
    cost = QuadraticCost([1.0, 0.1], [10.0, 1.0], [0.1], state_goal=[1.0, 0.0], input_goal=[0.0])
    cart = model.problem(cost, horizon=40, time_step=DT, bounds=Bounds(input_lower=[-FORCE], input_upper=[FORCE]))
    return Toy(cart, np.zeros(2), advance, lambda x: x[1] - SPEED)


def dense_solution(toy: Toy) -> Reference:
    """ProxQP's solution over the inputs alone, with all states written out as functions of them."""
    n, cost, dt = toy.problem.horizon, toy.problem.cost, toy.problem.time_step
    free, forced = np.zeros((n + 1, 2)), np.zeros((n + 1, 2, n))
    free[0] = toy.start
    for k in range(n):
        free[k + 1], forced[k + 1] = DYNAMICS @ free[k], DYNAMICS @ forced[k]
        forced[k + 1, :, k] += PUSH[:, 0]
    hessian, gradient, constant = dt * cost.input_weights[0] * np.eye(n), np.zeros(n), 0.0
    for k in range(n + 1):
        weights = np.diag(cost.terminal_weights if k == n else dt * cost.state_weights)
        off = free[k] - cost.state_goal
        hessian += forced[k].T @ weights @ forced[k]
        gradient += forced[k].T @ weights @ off
        constant += 0.5 * off @ weights @ off
    rows = np.vstack([forced[1:, 1], np.eye(n), -np.eye(n)])
    upper = np.concatenate([SPEED - free[1:, 1], np.full(2 * n, FORCE)])
    program = proxqp.dense.QP(n, 0, 3 * n)
    program.settings.eps_abs = 1e-11
    program.init(hessian, gradient, None, None, rows, np.full(3 * n, -1e20), upper)
    program.solve()
    u = program.results.x
    return Reference(free + forced @ u, u[:, None], float(0.5 * u @ hessian @ u + gradient @ u + constant))
