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
from doorman.ocp.kernels.functions import ModelFunction, at_node
from doorman.ocp.kernels.python_table import PythonModelFunctions, PythonTable
from doorman.ocp.problem.problem import Problem


class CompiledModel(FunctionTable):
    """A model's numbers and the compiled functions that solvers call on them.

    Args:
        content: The model.
        names: Of the functions that will be called.
    """

    __slots__ = ("_handle", "_names")

    def __init__(self, content: Any, names: Iterable[str]) -> None:
        self._handle, self._names = Handle(content), frozenset(names)
        addresses = [
            self._address(function) if name in self._names else 0 for name, function in ModelFunction.places.items()
        ]
        super().__init__(self._handle.address, addresses)

    @property
    def content(self) -> Any:
        """The model."""
        return self._handle.content

    def replace(self, content: Any) -> None:
        """Hold another model of the same type."""
        self._handle.replace(content)

    def _address(self, function: ModelFunction) -> int:
        kinds = self._handle._numba_type_, types.int64, *function.arguments
        return int(_ENTRIES[function.__name__].address(kinds, wrap))

    def __reduce__(self) -> tuple[Any, ...]:
        return CompiledModel, (self.content, self._names)


def table_of(content: Any, problem: Problem, curved: bool) -> CompiledModel | PythonTable:
    """The functions of a model that a solver of a problem calls."""
    if isinstance(content, PythonModelFunctions):
        return PythonTable(content)
    names = {"step", "linearize_step", "linearize_horizon"}
    if problem.n_constraints:
        names |= {"constrain", "linearize_constraints", "constrain_horizon"}
    if problem.n_input_constraints:
        names |= {"constrain_input", "linearize_input_constraints"}
    if problem.n_end_constraints:
        names |= {"constrain_end", "linearize_end_constraints"}
    if functions.has_own_cost(type(content)):
        names |= {"stage_cost", "expand_stage_cost", "end_cost", "expand_end_cost"}
    return CompiledModel(content, names | ({"curve_horizon"} if curved else set()))


def _of_node(function: ModelFunction) -> Callable[..., Any]:
    """Entry of a function of one node's model."""
    count = len(function.arguments)
    if count == 1:

        @kernel
        def of_one(model: Any, k: int, a: Any) -> Any:
            return function(at_node(model, k), a)

        return of_one
    if count == 2:

        @kernel
        def of_two(model: Any, k: int, a: Any, b: Any) -> Any:
            return function(at_node(model, k), a, b)

        return of_two
    if count == 3:

        @kernel
        def of_three(model: Any, k: int, a: Any, b: Any, c: Any) -> Any:
            return function(at_node(model, k), a, b, c)

        return of_three

    @kernel
    def of_four(model: Any, k: int, a: Any, b: Any, c: Any, d: Any) -> Any:
        return function(at_node(model, k), a, b, c, d)

    return of_four


@kernel
def _linearize_horizon(
    model: Any, k: int, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    functions.linearize_horizon(model, states, inputs, jacobians, rows, row_jacobians)


@kernel
def _constrain_horizon(model: Any, k: int, states: Array, rows: Array) -> None:
    functions.constrain_horizon(model, states, rows)


@kernel
def _curve_horizon(
    model: Any, k: int, states: Array, inputs: Array, costates: Array, prices: Array, nh: int, nt: int, ng: int,
    gradients: Array, hessians: Array,
) -> None:  # fmt: skip
    functions.curve_horizon(model, states, inputs, costates, prices, nh, nt, ng, gradients, hessians)


_ENTRIES: dict[str, Any] = {
    **{name: _of_node(function) for name, function in ModelFunction.places.items() if len(function.arguments) <= 4},
    "linearize_horizon": _linearize_horizon,
    "constrain_horizon": _constrain_horizon,
    "curve_horizon": _curve_horizon,
}
"""What a table's functions are made of, by their names."""
