"""A standard problem as CasADi functions and plain numbers: all that a solver in another environment is told of it."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EXAMPLES = Path(__file__).parents[3] / "examples" / "ocp"

NAMES = ("cart_pole", "unicycle", "two_link_arm", "race_car", "quadrotor", "chain")


@dataclass(frozen=True)
class Case:
    """A start, the node parameters (N + 1, nq) that belong to it, and the first guess that everybody gets."""

    start: Array
    node_parameters: Array
    states: Array
    inputs: Array


@dataclass(frozen=True)
class StandardTask:
    """One problem; functions are CasADi's, serialised."""

    name: str
    """Of the example's file."""
    title: str
    horizon: int
    time_step: float
    nx: int
    nu: int
    nq: int
    """Number of a node's parameters."""
    functions: dict[str, str]
    """step(x, u, q), rows(x, u, q) of nodes 0 … N − 1, state_rows(x, q) of nodes 1 … N, end_rows(x, q),
    stage_residual(x, u, q) and end_residual(x, q), whose half squares are the cost."""
    state_bounds: Array
    """Lower and upper at the nodes 1 … N, shape (2, nx)."""
    input_bounds: Array
    """Lower and upper, shape (2, nu)."""
    start_state: Case
    """The first case: what solvers are warmed up with."""

    def function(self, name: str) -> Any:
        """One of the functions."""
        return ca.Function.deserialize(self.functions[name])


def example(name: str) -> Any:
    """The example of a name; it needs doorman."""
    if str(EXAMPLES) not in sys.path:
        sys.path.insert(0, str(EXAMPLES))
    own = f"standard_{name}"
    if own not in sys.modules:
        found = importlib.util.spec_from_file_location(own, EXAMPLES / f"{name}.py")
        assert found is not None and found.loader is not None
        sys.modules[own] = importlib.util.module_from_spec(found)
        found.loader.exec_module(sys.modules[own])
    return sys.modules[own].EXAMPLE


def task_of(name: str) -> StandardTask:
    """An example as a task; the equations are written out again from its expressions, without doorman's kernels."""
    this = example(name)
    x, u, q = this.model.x, this.model.u, this.model.node_parameters
    functions = {
        "step": _function([x, u, q], [_step(this, x, u)]),
        **rows_and_residuals(x, u, q, this.time_step, this.constraints, this.cost, this.costs),
    }  # fmt: skip
    return StandardTask(
        name, this.name, this.horizon, this.time_step, x.numel(), u.numel(), q.numel(), functions,
        *arrays_of(this.bounds.of_sizes(x.numel(), u.numel())), cases_of(name, 1)[0],
    )  # fmt: skip


def rows_and_residuals(
    x: Any, u: Any, q: Any, time_step: float, constraints: Sequence[Any], cost: Any, costs: Sequence[Any]
) -> dict[str, str]:
    """The functions of a task that its constraints and costs make."""
    example(NAMES[0])  # brings in what the examples share
    one_sided = sys.modules["example"].one_sided
    placed: dict[str, list[Any]] = {"rows": [], "state_rows": [], "end_rows": []}
    for row in constraints:
        expression = one_sided(row) / row.scale
        kind = "end_rows" if row.at == "end" else "rows" if ca.depends_on(expression, u) else "state_rows"
        placed[kind].append(expression)
    step = ca.sqrt(time_step)
    stage = [
        step * ca.DM(np.sqrt(cost.state_weights)) * (x - cost.state_goal),
        step * ca.DM(np.sqrt(cost.input_weights)) * (u - cost.input_goal),
    ]
    end = [ca.DM(np.sqrt(cost.terminal_weights)) * (x - cost.state_goal)]
    for term in costs:
        weighted = ca.sqrt(ca.SX(term.weights)) * ca.vec(ca.SX(term.expression))
        (end if term.at == "end" else stage).append(weighted if term.at == "end" else step * weighted)
    return {
        "rows": _function([x, u, q], placed["rows"]), "state_rows": _function([x, q], placed["state_rows"]),
        "end_rows": _function([x, q], placed["end_rows"]),
        "stage_residual": _function([x, u, q], _without_zeros(stage)),
        "end_residual": _function([x, q], _without_zeros(end)),
    }  # fmt: skip


def discrete_step(x: Any, u: Any, q: Any, following: Any) -> str:
    """The function `step` of discrete dynamics."""
    return _function([x, u, q], [following])


def arrays_of(bounds: Any) -> tuple[Array, Array]:
    """Bounds of states and of inputs, lower and upper."""
    return (
        np.array([bounds.state_lower, bounds.state_upper]), np.array([bounds.input_lower, bounds.input_upper])
    )  # fmt: skip


def cases_of(name: str, count: int, seed: int = 1) -> list[Case]:
    """An example's perturbed starts with their guesses."""
    this = example(name)
    return [case_of(this, start) for start in this.starts(count, seed)]


def case_of(this: Any, start: Array) -> Case:
    """A start with what belongs to it."""
    parameters = np.zeros((this.horizon + 1, 0)) if this.node_parameters is None else this.node_parameters(start)
    return Case(start, parameters, *this.guess(start))


def _step(this: Any, x: Any, u: Any) -> Any:
    """x⁺ by RK4."""
    rate, h, state = ca.Function("rate", [x, u], [this.rate]), this.time_step / this.model.steps, x
    for _ in range(this.model.steps):
        k1 = rate(state, u)
        k2 = rate(state + h / 2 * k1, u)
        k3 = rate(state + h / 2 * k2, u)
        k4 = rate(state + h * k3, u)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state


def _function(arguments: list[Any], results: list[Any]) -> str:
    column = ca.densify(ca.vertcat(ca.SX(0, 1), *results))
    text: str = ca.Function("f", arguments, [column]).serialize()
    return text


def _without_zeros(residuals: list[Any]) -> list[Any]:
    """Residuals of weight zero are none."""
    column = ca.vertcat(*residuals)
    return [column[i] for i in range(column.numel()) if not column[i].is_zero()]
