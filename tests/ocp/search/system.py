"""A problem in symbols beside its twin for IPOPT, by multiple shooting, written out of the same expressions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman import ocp

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Found:
    """What IPOPT has found."""

    success: bool
    cost: float
    states: Array
    inputs: Array
    prices: Array
    """Of the rows of all terms."""
    bound_prices: Array
    """Of the inputs' bounds, (N, nu)."""
    costates: Array
    """Of f(x_k, u_k) − x_{k+1}, (N, nx)."""


@dataclass(frozen=True, eq=False)
class System:
    """Dynamics, cost, bounds, terms, and where a solve starts."""

    x: Any
    u: Any
    rate: Any
    horizon: int
    time_step: float
    cost: ocp.QuadraticCost
    start: ArrayLike
    spread: ArrayLike
    """Of perturbed starts."""
    bounds: ocp.Bounds = field(default_factory=ocp.Bounds)
    constraints: tuple[ocp.Constraint, ...] = ()
    costs: tuple[ocp.Cost | ocp.Residual, ...] = ()

    def problem(self, **options: Any) -> ocp.Problem:
        """For doorman's solvers."""
        model = ocp.SymbolicModel(self.x, self.u, self.rate)
        return model.problem(
            self.horizon, self.time_step, self.cost, bounds=self.bounds, constraints=self.constraints, costs=self.costs,
            **options,
        )  # fmt: skip

    def starts(self, count: int, seed: int = 0) -> Iterator[Array]:
        """Perturbed starts."""
        random = np.random.default_rng(seed)
        for _ in range(count):
            yield np.asarray(self.start) + np.asarray(self.spread) * random.uniform(-1.0, 1.0, self.x.numel())

    def held(self, start: Array) -> Array:
        """Guess of states: the start at all nodes."""
        return np.tile(start, (self.horizon + 1, 1))

    def step(self, x: Any, u: Any) -> Any:
        """x⁺, one step of RK4."""
        rate, h = ca.Function("rate", [self.x, self.u], [self.rate]), self.time_step
        a = rate(x, u)
        b = rate(x + h / 2 * a, u)
        c = rate(x + h / 2 * b, u)
        return x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c, u))

    def ipopt(self, start: Array, states: Array, inputs: Array, tolerance: float = 1e-9) -> Found:
        """IPOPT's solution from a guess."""
        nx, nu, n = self.x.numel(), self.u.numel(), self.horizon
        X, U = ca.SX.sym("X", nx, n + 1), ca.SX.sym("U", nu, n)
        rows: list[tuple[Any, float, float]] = [(X[:, 0] - start, 0.0, 0.0)]
        for k in range(n):
            rows.append((self.step(X[:, k], U[:, k]) - X[:, k + 1], 0.0, 0.0))
        for term in self.constraints:
            rows += [(value, *_ends(term)) for value in self._values(term, X, U)]
        limits = self.bounds.of_sizes(nx, nu)
        lower = [np.full(nx, -np.inf), *[limits.state_lower] * n, *[limits.input_lower] * n]
        upper = [np.full(nx, np.inf), *[limits.state_upper] * n, *[limits.input_upper] * n]
        nlp = {
            "x": ca.vertcat(ca.vec(X), ca.vec(U)), "f": self.total(X, U), "g": ca.vertcat(*[row for row, _, _ in rows])
        }  # fmt: skip
        options = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes", "ipopt.tol": tolerance}
        solver = ca.nlpsol("ipopt", "ipopt", nlp, options)
        found = solver(
            x0=np.concatenate([states.ravel(), inputs.ravel()]), lbx=np.concatenate(lower), ubx=np.concatenate(upper),
            lbg=np.concatenate([np.full(row.numel(), low) for row, low, _ in rows]),
            ubg=np.concatenate([np.full(row.numel(), high) for row, _, high in rows]),
        )  # fmt: skip
        z, prices = np.array(found["x"]).ravel(), np.array(found["lam_g"]).ravel()
        return Found(
            bool(solver.stats()["success"]), float(found["f"]),
            z[: (n + 1) * nx].reshape(n + 1, nx), z[(n + 1) * nx :].reshape(n, nu),
            prices[(n + 1) * nx :], np.array(found["lam_x"]).ravel()[(n + 1) * nx :].reshape(n, nu),
            prices[nx : (n + 1) * nx].reshape(n, nx),
        )  # fmt: skip

    def total(self, X: Any, U: Any) -> Any:
        """J of columns of states and inputs."""
        cost, n, total = self.cost, self.horizon, ca.SX(0)
        for k in range(n):
            state_error, input_error = X[:, k] - cost.state_goal, U[:, k] - cost.input_goal
            total += 0.5 * self.time_step * _weighed(cost.state_weights, state_error)
            total += 0.5 * self.time_step * _weighed(cost.input_weights, input_error)
            if cost.cross_weights is not None:
                total += self.time_step * ca.bilin(ca.DM(cost.cross_weights), input_error, state_error)
        total += 0.5 * _weighed(cost.terminal_weights, X[:, n] - cost.state_goal)
        for term in self.costs:
            for value in self._values(term, X, U):
                squares = isinstance(term, ocp.Residual)
                number = 0.5 * ca.dot(ca.DM(term.weights) * value, value) if squares else value
                total += number if term.at == "end" else self.time_step * number
        return total

    def _values(self, term: Any, X: Any, U: Any) -> list[Any]:
        """A term's expression at the nodes where it counts."""
        expression = ca.vec(ca.SX(term.expression)) / getattr(term, "scale", 1.0)
        function = ca.Function("term", [self.x, self.u], [expression])
        n = self.horizon
        if term.at == "end":
            return [function(X[:, n], ca.SX.zeros(self.u.numel()))]
        if isinstance(term, ocp.Constraint) and not ca.depends_on(expression, self.u):
            return [function(X[:, k + 1], U[:, k]) for k in range(n)]
        return [function(X[:, k], U[:, k]) for k in range(n)]


def _weighed(weights: Array, error: Any) -> Any:
    """eᵀ W e."""
    return ca.bilin(ca.DM(weights), error, error) if weights.ndim == 2 else ca.dot(ca.DM(weights) * error, error)


def _ends(term: ocp.Constraint) -> tuple[float, float]:
    """Lower and upper end of a constraint's rows, which have one for all."""
    if term.equals is not None:
        return float(term.equals) / term.scale, float(term.equals) / term.scale
    upper = 0.0 if term.upper is None and term.lower is None else term.upper
    return (
        -np.inf if term.lower is None else float(term.lower) / term.scale,
        np.inf if upper is None else float(upper) / term.scale,
    )
