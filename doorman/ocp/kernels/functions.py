"""The functions that make an optimal control problem, and how a model supplies them to compiled solvers.

A model is a NamedTuple of numbers and arrays; its type decides which kernels are called. numba resolves the names below at
compile time by that type. Solvers take a table of these functions instead, compiled once for the type of model
(`doorman.ocp.kernels.compiled_model`): they call by the same names, at addresses. Only `step` is obligatory: constraints and
costs that a model does not have count as absent, and a missing derivative is taken by central differences
(`doorman.ocp.kernels.defaults`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba.core import types
from numba.extending import overload

from doorman.arrays import Array
from doorman.numba_types.function_tables import TABLE, with_number
from doorman.ocp.kernels.supplying import ARGUMENTS as ARGUMENTS
from doorman.ocp.kernels.supplying import compiled, content_of, implementations, instance_class, kernel_of, type_of
from doorman.ocp.kernels.supplying import default as default
from doorman.ocp.kernels.supplying import implement as implement
from doorman.ocp.kernels.supplying import is_implemented as is_implemented

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

_COUNTS = types.UniTuple(types.int64, 3)  # type: ignore[no-untyped-call]


def at_node(model: Any, k: int) -> Any:
    """The model as node k sees it: itself, or what a model whose numbers change along the horizon has for that node."""
    choose = implementations.get(("at_node", type_of(model)))
    return model if choose is None else choose(content_of(model), k)


@overload(at_node, strict=False)
def _compiled_at_node(model: Any, k: Any) -> Any:
    """Compiled into its callers: a handle goes through unchanged, and a table's functions choose themselves."""
    if model is TABLE:
        return lambda model, k: with_number(model, k)
    choose = implementations.get(("at_node", instance_class(model)))
    return (lambda model, k: model) if choose is None else choose


@compiled(1, 1, 1)
def step(model: Any, x: Array, u: Array, out: Array) -> None:
    """Discrete dynamics, x⁺ = f(x, u)."""
    kernel_of("step", type_of(model))(model, x, u, out)


@compiled(1, 1, 2)
def linearize_step(model: Any, x: Array, u: Array, jacobian: Array) -> None:
    """Jacobian [A | B] of `step`."""
    kernel_of("linearize_step", type_of(model))(model, x, u, jacobian)


@compiled(1, 1)
def constrain(model: Any, x: Array, h: Array) -> None:
    """Constraints h(x) ≤ 0 of every state after the first."""
    kernel_of("constrain", type_of(model))(model, x, h)


@compiled(1, 1, 2)
def linearize_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    """Constraints h(x) ≤ 0 of a state, and their Jacobian."""
    kernel_of("linearize_constraints", type_of(model))(model, x, h, jacobian)


@compiled(1, 1, 1)
def constrain_input(model: Any, x: Array, u: Array, g: Array) -> None:
    """Mixed constraints g(x, u) ≤ 0 of every node but the last."""
    kernel_of("constrain_input", type_of(model))(model, x, u, g)


@compiled(1, 1, 1, 2)
def linearize_input_constraints(model: Any, x: Array, u: Array, g: Array, jacobian: Array) -> None:
    """Mixed constraints g(x, u) ≤ 0, and their Jacobian."""
    kernel_of("linearize_input_constraints", type_of(model))(model, x, u, g, jacobian)


@compiled(1, 1)
def constrain_end(model: Any, x: Array, h: Array) -> None:
    """Constraints h_N(x_N) ≤ 0 of the last state only."""
    kernel_of("constrain_end", type_of(model))(model, x, h)


@compiled(1, 1, 2)
def linearize_end_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    """Constraints h_N(x_N) ≤ 0 of the last state, and their Jacobian."""
    kernel_of("linearize_end_constraints", type_of(model))(model, x, h, jacobian)


@compiled(1, 1, returns=types.float64)
def stage_cost(model: Any, x: Array, u: Array) -> float:
    """Cost of a node on top of the quadratic one, already times Δt."""
    return float(kernel_of("stage_cost", type_of(model))(model, x, u))


@compiled(1, 1, 1, 2)
def expand_stage_cost(model: Any, x: Array, u: Array, gradient: Array, hessian: Array) -> None:
    """Gradient and positive semidefinite Hessian of `stage_cost`, or the Gauss-Newton Hessian."""
    kernel_of("expand_stage_cost", type_of(model))(model, x, u, gradient, hessian)


@compiled(1, returns=types.float64)
def end_cost(model: Any, x: Array) -> float:
    """Cost of the last state on top of the quadratic one."""
    return float(kernel_of("end_cost", type_of(model))(model, x))


@compiled(1, 1, 2)
def expand_end_cost(model: Any, x: Array, gradient: Array, hessian: Array) -> None:
    """Gradient and positive semidefinite Hessian of `end_cost`, or the Gauss-Newton Hessian."""
    kernel_of("expand_end_cost", type_of(model))(model, x, gradient, hessian)


@compiled(2, 2, 3, 2, 3)
def linearize_horizon(
    model: Any, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    """All nodes at once; a model may have a kernel that takes many nodes side by side."""
    kernel_of("linearize_horizon", type_of(model))(model, states, inputs, jacobians, rows, row_jacobians)


@compiled(2, 2)
def constrain_horizon(model: Any, states: Array, rows: Array) -> None:
    """Constraints h(x) of all nodes 1 … N at once."""
    kernel_of("constrain_horizon", type_of(model))(model, states, rows)


@compiled(2, 2, 2, 2, _COUNTS, 2, 3)
def curve_horizon(
    model: Any, states: Array, inputs: Array, costates: Array, prices: Array, counts: tuple[int, int, int],
    gradients: Array, hessians: Array,
) -> None:  # fmt: skip
    """Second derivatives of the Lagrangian ℓ + pᵀf + yᵀ(h, h_N, g) at all nodes, without the quadratic cost."""
    kernel_of("curve_horizon", type_of(model))(model, states, inputs, costates, prices, counts, gradients, hessians)
