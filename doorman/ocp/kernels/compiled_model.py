"""A model as solvers take it: a table of its functions, so that solvers are compiled for sizes and not for models."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from numba.core import types

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.function_tables import FunctionTable, wrap
from doorman.numba_types.handles import Handle
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.functions import at_node
from doorman.ocp.problem.problem import Problem

_entries: dict[str, Any] = {}
"""What a table's functions are made of, by their names."""


class CompiledModel(FunctionTable):
    """A model's numbers and the compiled functions that solvers call on them.

    Args:
        content: The model.
        names: Of the functions that will be called.
    """

    __slots__ = ("_handle", "_names")

    def __init__(self, content: Any, names: Iterable[str]) -> None:
        self._handle, self._names = Handle(content), frozenset(names)
        super().__init__(
            self._handle.address,
            [self._address(name, kinds) if name in self._names else 0 for name, kinds in functions.ARGUMENTS.items()],
        )

    @property
    def content(self) -> Any:
        """The model."""
        return self._handle.content

    def replace(self, content: Any) -> None:
        """Hold another model of the same type."""
        self._handle.replace(content)

    def _address(self, name: str, kinds: tuple[Any, ...]) -> int:
        return int(_entries[name].address((self._handle._numba_type_, types.int64, *kinds), wrap))

    def __reduce__(self) -> tuple[Any, ...]:
        return CompiledModel, (self.content, self._names)


def called_functions(problem: Problem, has_cost: bool, curved: bool) -> set[str]:
    """Names of the functions that a solver calls."""
    names = {"step", "linearize_step", "linearize_horizon"}
    if problem.n_constraints:
        names |= {"constrain", "linearize_constraints", "constrain_horizon"}
    if problem.n_input_constraints:
        names |= {"constrain_input", "linearize_input_constraints"}
    if problem.n_end_constraints:
        names |= {"constrain_end", "linearize_end_constraints"}
    if has_cost:
        names |= {"stage_cost", "expand_stage_cost", "end_cost", "expand_end_cost"}
    return names | ({"curve_horizon"} if curved else set())


def _entry(function: Callable[..., Any]) -> Callable[..., Any]:
    _entries[function.__name__[1:]] = entry = kernel(function)
    return entry


@_entry
def _step(model: Any, k: int, x: Array, u: Array, out: Array) -> None:
    functions.step(at_node(model, k), x, u, out)


@_entry
def _linearize_step(model: Any, k: int, x: Array, u: Array, jacobian: Array) -> None:
    functions.linearize_step(at_node(model, k), x, u, jacobian)


@_entry
def _constrain(model: Any, k: int, x: Array, h: Array) -> None:
    functions.constrain(at_node(model, k), x, h)


@_entry
def _linearize_constraints(model: Any, k: int, x: Array, h: Array, jacobian: Array) -> None:
    functions.linearize_constraints(at_node(model, k), x, h, jacobian)


@_entry
def _constrain_input(model: Any, k: int, x: Array, u: Array, g: Array) -> None:
    functions.constrain_input(at_node(model, k), x, u, g)


@_entry
def _linearize_input_constraints(model: Any, k: int, x: Array, u: Array, g: Array, jacobian: Array) -> None:
    functions.linearize_input_constraints(at_node(model, k), x, u, g, jacobian)


@_entry
def _constrain_end(model: Any, k: int, x: Array, h: Array) -> None:
    functions.constrain_end(at_node(model, k), x, h)


@_entry
def _linearize_end_constraints(model: Any, k: int, x: Array, h: Array, jacobian: Array) -> None:
    functions.linearize_end_constraints(at_node(model, k), x, h, jacobian)


@_entry
def _stage_cost(model: Any, k: int, x: Array, u: Array) -> float:
    return functions.stage_cost(at_node(model, k), x, u)


@_entry
def _expand_stage_cost(model: Any, k: int, x: Array, u: Array, gradient: Array, hessian: Array) -> None:
    functions.expand_stage_cost(at_node(model, k), x, u, gradient, hessian)


@_entry
def _end_cost(model: Any, k: int, x: Array) -> float:
    return functions.end_cost(at_node(model, k), x)


@_entry
def _expand_end_cost(model: Any, k: int, x: Array, gradient: Array, hessian: Array) -> None:
    functions.expand_end_cost(at_node(model, k), x, gradient, hessian)


@_entry
def _linearize_horizon(
    model: Any, k: int, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    functions.linearize_horizon(model, states, inputs, jacobians, rows, row_jacobians)


@_entry
def _constrain_horizon(model: Any, k: int, states: Array, rows: Array) -> None:
    functions.constrain_horizon(model, states, rows)


@_entry
def _curve_horizon(
    model: Any,
    k: int,
    states: Array,
    inputs: Array,
    costates: Array,
    prices: Array,
    counts: tuple[int, int, int],
    gradients: Array,
    hessians: Array,
) -> None:
    functions.curve_horizon(model, states, inputs, costates, prices, counts, gradients, hessians)
