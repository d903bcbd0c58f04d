"""A problem of a user's own that has everything: a cart with a boom before a wall, and IPOPT's solution of it.

State [p, v, q] and input [a, r]: the cart's place and speed, the boom's length; its acceleration, the boom's rate. A double
integrator where `bend` is zero. All variants have the same sizes, so that their solvers share one set of kernels: what a
variant does not have is a row or bound far away.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.ocp import Bounds, Problem, QuadraticCost, functions

Array = NDArray[np.float64]

N, STEP = 30, 0.1
FAR = 100.0
COST = QuadraticCost(
    state_weights=np.array([1.0, 0.1, 0.2]),
    terminal_weights=np.array([10.0, 1.0, 0.5]),
    input_weights=np.array([0.1, 0.05]),
    state_goal=np.array([1.0, 0.0, 0.3]),
    input_goal=np.zeros(2),
)
NAMES = ("wall", "speed", "power", "dock")


class Cart(NamedTuple):
    """Numbers of the kernels."""

    time_step: float
    wall: float
    """h: p + reach q ≤ wall."""
    reach: float
    speed: float
    """h: v ≤ speed."""
    power: float
    """g: a + v ≤ power."""
    dock: float
    """h_N: p ≥ dock."""
    bend: float
    """Acceleration by sin p; where it is huge, numbers get out of hand."""
    slope: float
    """Factor on the Jacobian of the input: 1, or something else to make it wrong."""
    probe: Array
    """Linearised nodes so far; the one that waits for `probe[2]` to be set, or for the time `probe[3]` on the clock."""


@kernel
def acceleration(cart: Cart, x: Array, u: Array) -> float:
    return u[0] + cart.bend * np.sin(x[0])


@functions.implement(functions.step, Cart)
@kernel
def _step(cart: Cart, x: Array, u: Array, out: Array) -> None:
    h, a = cart.time_step, acceleration(cart, x, u)
    out[0] = x[0] + h * x[1] + 0.5 * h * h * a
    out[1] = x[1] + h * a
    out[2] = x[2] + h * u[1]


@functions.implement(functions.linearize_step, Cart)
@kernel
def _linearize_step(cart: Cart, x: Array, u: Array, out: Array) -> None:
    cart.probe[0] += 1.0
    if cart.probe[0] == cart.probe[1]:
        while cart.probe[2] == 0.0 and clock() < cart.probe[3]:
            pass
    h, turn = cart.time_step, cart.bend * np.cos(x[0])
    out[:, :] = 0.0
    out[0, 0] = 1.0 + 0.5 * h * h * turn
    out[0, 1] = h
    out[0, 3] = 0.5 * h * h * cart.slope
    out[1, 0] = h * turn
    out[1, 1] = 1.0
    out[1, 3] = h * cart.slope
    out[2, 2] = 1.0
    out[2, 4] = h


@functions.implement(functions.constrain, Cart)
@kernel
def _constrain(cart: Cart, x: Array, h: Array) -> None:
    h[0] = x[0] + cart.reach * x[2] - cart.wall
    h[1] = x[1] - cart.speed


@functions.implement(functions.linearize_constraints, Cart)
@kernel
def _linearize_constraints(cart: Cart, x: Array, h: Array, jacobian: Array) -> None:
    h[0] = x[0] + cart.reach * x[2] - cart.wall
    h[1] = x[1] - cart.speed
    jacobian[:, :] = 0.0
    jacobian[0, 0] = 1.0
    jacobian[0, 2] = cart.reach
    jacobian[1, 1] = 1.0


@functions.implement(functions.constrain_input, Cart)
@kernel
def _constrain_input(cart: Cart, x: Array, u: Array, g: Array) -> None:
    g[0] = u[0] + x[1] - cart.power


@functions.implement(functions.linearize_input_constraints, Cart)
@kernel
def _linearize_input_constraints(cart: Cart, x: Array, u: Array, g: Array, jacobian: Array) -> None:
    g[0] = u[0] + x[1] - cart.power
    jacobian[:, :] = 0.0
    jacobian[0, 1] = 1.0
    jacobian[0, 3] = 1.0


@functions.implement(functions.constrain_end, Cart)
@kernel
def _constrain_end(cart: Cart, x: Array, h: Array) -> None:
    h[0] = cart.dock - x[0]


@functions.implement(functions.linearize_end_constraints, Cart)
@kernel
def _linearize_end_constraints(cart: Cart, x: Array, h: Array, jacobian: Array) -> None:
    h[0] = cart.dock - x[0]
    jacobian[:, :] = 0.0
    jacobian[0, 0] = -1.0


@dataclass(frozen=True)
class Variant:
    """A cart's task; what is not given is far away."""

    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wall: float = FAR
    reach: float = 0.0
    speed: float = FAR
    power: float = FAR
    dock: float = -FAR
    bend: float = 0.0
    slope: float = 1.0
    force: tuple[float, float] = (-FAR, FAR)
    """Bounds of a."""
    rate: tuple[float, float] = (-FAR, FAR)
    """Bounds of r."""
    room: tuple[float, float] = (-FAR, FAR)
    """Bounds of p."""
    boom: tuple[float, float] = (-FAR, FAR)
    """Bounds of q."""
    horizon: int = N
    probe: Array = field(default_factory=lambda: np.zeros(4), compare=False)

    def model(self) -> Cart:
        """Numbers of the kernels."""
        return Cart(
            STEP, self.wall, self.reach, self.speed, self.power, self.dock, self.bend, self.slope, self.probe
        )  # fmt: skip

    def problem(self) -> Problem:
        """For the solvers."""
        bounds = Bounds(
            state_lower=[self.room[0], -np.inf, self.boom[0]],
            state_upper=[self.room[1], np.inf, self.boom[1]],
            input_lower=[self.force[0], self.rate[0]],
            input_upper=[self.force[1], self.rate[1]],
        )
        return Problem(
            self.model(), n_constraints=2, n_input_constraints=1, n_end_constraints=1, integrators=1, bounds=bounds,
            constraint_names=NAMES, horizon=self.horizon, time_step=STEP, cost=COST,
        )  # fmt: skip

    def violation(self, states: Array, inputs: Array) -> float:
        """Largest violated row or bound of a trajectory, written out."""
        (p, v, q), (a, r) = states[1:].T, inputs.T
        rows = [
            p + self.reach * q - self.wall, v - self.speed, a + states[:-1, 1] - self.power, self.dock - p[-1:],
            *(side for x, (low, high) in ((a, self.force), (r, self.rate), (p, self.room), (q, self.boom))
              for side in (low - x, x - high)),
        ]  # fmt: skip
        return max(0.0, max(float(row.max()) for row in rows))

    def defect(self, states: Array, inputs: Array) -> float:
        """Largest error of a trajectory in the dynamics, written out."""
        (p, v, q), (a, r) = states[:-1].T, inputs.T
        pushed = a + self.bend * np.sin(p)
        expected = np.column_stack([p + STEP * v + 0.5 * STEP**2 * pushed, v + STEP * pushed, q + STEP * r])
        return float(np.abs(states[1:] - expected).max())

    def reference(self) -> Reference:
        """IPOPT's solution."""
        numbers = [self.reach, self.bend]
        low = [self.force[0], self.rate[0], self.room[0], -np.inf, self.boom[0]]
        high = [self.force[1], self.rate[1], self.room[1], np.inf, self.boom[1]]
        lower = np.tile([0.0, 0.0, 0.0, -np.inf, -np.inf, -np.inf], N)
        upper = np.tile([0.0, 0.0, 0.0, self.wall, self.speed, self.power], N)
        result = _ipopt()(
            x0=0.0, p=np.array([*self.start, *numbers]), lbx=np.tile(low, N), ubx=np.tile(high, N),
            lbg=np.append(lower, self.dock), ubg=np.append(upper, np.inf),
        )  # fmt: skip
        assert _ipopt().stats()["success"]
        z = np.array(result["x"]).reshape(N, 5)
        return Reference(np.vstack([self.start, z[:, 2:]]), z[:, :2], float(result["f"]))


@dataclass(frozen=True)
class Reference:
    """Optimum found by IPOPT."""

    states: Array
    inputs: Array
    cost: float


@cache
def _ipopt() -> Any:
    parameters = ca.SX.sym("p", 5)
    z = ca.SX.sym("z", 5, N)
    x, reach, bend = parameters[:3], parameters[3], parameters[4]
    cost, rows = 0.0, []
    goal, by_state, by_input = ca.DM(COST.state_goal), ca.DM(COST.state_weights), ca.DM(COST.input_weights)
    for k in range(N):
        u, after = z[:2, k], z[2:, k]
        a = u[0] + bend * ca.sin(x[0])
        ahead = ca.vertcat(x[0] + STEP * x[1] + 0.5 * STEP**2 * a, x[1] + STEP * a, x[2] + STEP * u[1])
        cost += 0.5 * STEP * (ca.dot(by_state, (x - goal) ** 2) + ca.dot(by_input, u**2))
        rows += [after - ahead, after[0] + reach * after[2], after[1], u[0] + x[1]]
        x = after
    cost += 0.5 * ca.dot(ca.DM(COST.terminal_weights), (x - goal) ** 2)
    program = {"x": ca.vec(z), "p": parameters, "f": cost, "g": ca.vertcat(*rows, x[0])}
    settings = {
        "ipopt.tol": 1e-11, "ipopt.constr_viol_tol": 1e-10, "ipopt.acceptable_tol": 1e-11, "ipopt.print_level": 0,
        "ipopt.bound_relax_factor": 0.0, "ipopt.sb": "yes", "print_time": False,
    }  # fmt: skip
    return ca.nlpsol("cart", "ipopt", program, settings)
