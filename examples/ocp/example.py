"""What the examples of this folder share: a problem with its starts, a first guess, a closed loop and a goal."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from doorman import ocp

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Flight:
    """A closed loop: every plan begins at the measured state, and its first input is applied for one time step."""

    states: Array
    """Of the plant, shape (steps + 1, nx)."""
    inputs: Array
    """Applied, shape (steps, nu)."""
    statuses: list[ocp.PlanStatus]
    """Of the plans."""
    seconds: Array
    """That the plans took, shape (steps,)."""


@dataclass(frozen=True)
class Example:
    """An optimal control problem, as expressions, and what belongs to a closed loop of it."""

    name: str
    source: str
    """Where dynamics and numbers come from."""
    model: ocp.SymbolicModel
    rate: Any
    """ẋ, the expression that the model is made of."""
    horizon: int
    time_step: float
    """[s]."""
    cost: ocp.QuadraticCost
    start: Sequence[float]
    """Middle of the starts."""
    spread: Sequence[float]
    """Largest distance of a start from there, for each state."""
    reached: Callable[[Array], bool]
    """Whether a closed loop's states (steps + 1, nx) reach the goal."""
    steps: int
    """Of the closed loop."""
    noise: Sequence[float]
    """Standard deviation of what disturbs each state in every step."""
    bounds: ocp.Bounds = field(default_factory=ocp.Bounds)
    constraints: Sequence[ocp.Constraint] = ()
    costs: Sequence[ocp.Cost | ocp.Residual] = ()
    node_parameters: Callable[[Array], Array] | None = None
    """Parameters of nodes 0 … N of the problem that begins at a state, shape (N + 1, nq)."""
    end: Callable[[Array], Array] | None = None
    """Last state of the first guess for a start; the goal of the cost if not given."""
    draw: Callable[[Any, Array], None] | None = None
    """Draw a closed loop's states on axes of matplotlib."""

    def problem(self, start: Array | None = None) -> ocp.Problem:
        """The problem; its node parameters are those of a start."""
        at = np.asarray(self.start if start is None else start, dtype=float)
        return self.model.problem(
            self.horizon, self.time_step, self.cost, bounds=self.bounds, constraints=self.constraints, costs=self.costs,
            node_parameters=None if self.node_parameters is None else self.node_parameters(at),
        )  # fmt: skip

    def starts(self, count: int, seed: int = 1) -> Array:
        """Perturbed starts, shape (count, nx)."""
        random = np.random.default_rng(seed)
        return np.asarray(self.start) + np.asarray(self.spread) * random.uniform(-1.0, 1.0, (count, len(self.start)))

    def guess(self, start: Array) -> tuple[Array, Array]:
        """First guess: a straight line of states (N + 1, nx), and the cost's input goal (N, nu)."""
        end = self.cost.state_goal if self.end is None else self.end(start)
        return np.linspace(start, end, self.horizon + 1), np.tile(self.cost.input_goal, (self.horizon, 1))

    def solve(self, solver: ocp.Hybrid, start: Array) -> ocp.Solution:
        """Cold solve from the first guess."""
        self._aim(solver, start)
        states, inputs = self.guess(start)
        return solver.solve(start, inputs, states=states)

    def fly(self, solver: ocp.Hybrid, start: Array, seed: int = 1) -> Flight:
        """Solve once, then replan at every time step; the plant is integrated more finely, and disturbed."""
        random, noise = np.random.default_rng(seed), np.asarray(self.noise)
        state, solution = np.array(start, dtype=float), self.solve(solver, start)
        plan, states, inputs = solution.inputs, [state], []
        statuses, seconds = [solution.status], [solution.timings.total]
        for _ in range(self.steps):
            inputs.append(plan[0])
            state = self.plant(state, plan[0]) + noise * random.standard_normal(len(state))
            begun = time.perf_counter()
            self._aim(solver, state)
            status, _ = solver.replan(state, elapsed=self.time_step)
            seconds.append(time.perf_counter() - begun)
            plan = solver.trajectory()[1] if status.flyable else np.vstack([plan[1:], plan[-1:]])
            states.append(state)
            statuses.append(status)
        return Flight(np.array(states), np.array(inputs), statuses, np.array(seconds))

    def plant(self, state: Array, inputs: Array) -> Array:
        """State after a time step, by four steps of RK4."""
        return np.array(self._plant(state, inputs)).ravel()

    def violation(self, states: Array, inputs: Array) -> float:
        """Largest violation of constraints and input bounds along a closed loop, 0 if none [the row's unit]."""
        rows = [np.array(self._rows(x, u)).max(initial=0.0) for x, u in zip(states[1:-1], inputs[1:], strict=True)]
        bounds = self.bounds.of_sizes(states.shape[1], inputs.shape[1])
        beyond = [
            np.maximum(np.asarray(lower) - values, values - np.asarray(upper)).max()
            for values, lower, upper in (
                (states[1:], bounds.state_lower, bounds.state_upper), (inputs, bounds.input_lower, bounds.input_upper)
            )
        ]  # fmt: skip
        return float(max(0.0, *rows, *beyond))

    def main(self) -> None:
        """Solve, fly, say how it went; with --draw, write a picture."""
        parser = argparse.ArgumentParser(description=f"{self.name}, after {self.source}")
        parser.add_argument("--draw", metavar="FILE", help="picture of the closed loop, which needs matplotlib")
        parser.add_argument("--seed", type=int, default=1, help="of start and disturbance")
        arguments = parser.parse_args()
        solver, start = ocp.Hybrid(self.problem()), self.starts(1, arguments.seed)[0]
        solution = self.solve(solver, start)
        print(f"{self.name}: {solution.message()}, in {1e3 * solution.solve_time:.2f} ms")
        flight = self.fly(solver, start, arguments.seed)
        replans = 1e3 * flight.seconds[1:]
        print(f"replans: median {np.median(replans):.2f} ms, slowest {replans.max():.2f} ms")
        print("goal reached" if self.reached(flight.states) else "goal not reached")
        if arguments.draw:
            self._picture(flight.states, arguments.draw)

    def _picture(self, states: Array, path: str) -> None:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(7, 4), layout="constrained")
        axes = figure.subplots()
        axes.set(title=self.name)
        if self.draw is not None:
            self.draw(axes, states)
        figure.savefig(path, dpi=110)

    def _aim(self, solver: ocp.Hybrid, state: Array) -> None:
        if self.node_parameters is not None:
            solver.update_parameters(node_parameters=self.node_parameters(state))

    @cached_property
    def _plant(self) -> Any:
        x, u = self.model.x, self.model.u
        rate, h, state = ca.Function("rate", [x, u], [self.rate]), self.time_step / 4, x
        for _ in range(4):
            a = rate(state, u)
            b = rate(state + h / 2 * a, u)
            c = rate(state + h / 2 * b, u)
            d = rate(state + h * c, u)
            state = state + h / 6 * (a + 2 * b + 2 * c + d)
        return ca.Function("plant", [x, u], [state])

    @cached_property
    def _rows(self) -> Any:
        rows = [one_sided(row) for row in self.constraints if row.at == "stages"]
        return ca.Function("rows", [self.model.x, self.model.u], [ca.densify(ca.vertcat(ca.SX(0, 1), *rows))])


def one_sided(constraint: ocp.Constraint) -> Any:
    """Rows of a constraint that are not positive where it holds, unscaled."""
    expression, ends = ca.vec(ca.SX(constraint.expression)), []
    if constraint.upper is not None or constraint.lower is None:
        ends.append(expression - (0.0 if constraint.upper is None else constraint.upper))
    if constraint.lower is not None:
        ends.append(constraint.lower - expression)
    return ca.vertcat(*ends)
