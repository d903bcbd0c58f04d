"""Plain Python functions as a model for the compiled solvers: a table of C functions that call back into Python.

Kernels hold no lock; `ctypes` takes the GIL for each call. No exception gets through compiled code: the model keeps it, answers
NaN from then on, so that the solver ends soon, and the solver raises it.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numba.core import types

from doorman.arrays import Array
from doorman.numba_types.function_tables import FunctionTable
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.functions import ModelFunction
from doorman.ocp.kernels.python_functions import CheckedFunction


class PythonModelFunctions:
    """The model: functions of a problem by name, and what they have raised.

    Args:
        checked: The functions.
    """

    def __init__(self, checked: dict[str, CheckedFunction]) -> None:
        self.checked = checked
        self.failure: BaseException | None = None

    def _separate(self) -> PythonModelFunctions:
        """A model of these functions, with failures of its own."""
        return type(self)(self.checked)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.checked,)

    def forget_failures(self) -> None:
        """Forget what a function has raised."""
        self.failure = None

    def raise_failure(self) -> None:
        """Raise what a function has raised, once."""
        failure, self.failure = self.failure, None
        if failure is not None:
            raise failure

    def result(self, name: str, wanted: str, given: tuple[Array, ...]) -> Any:
        """What a function, or a method of it, has for some arguments."""
        function = self.checked.get(name)
        if function is None:
            return 0.0
        if self.failure is not None or not all(np.isfinite(argument).all() for argument in given):
            return math.nan
        return getattr(function, wanted)(*given)


class PythonModelWithCost(PythonModelFunctions):
    """Functions with a cost among them: another type, as solvers ask types for the cost."""


class PythonTable(FunctionTable):
    """C functions of a model, as solvers call them.

    Args:
        content: The model.
    """

    __slots__ = ("content", "_functions")

    def __init__(self, content: PythonModelFunctions) -> None:
        self.content = content
        self._functions = [self._c_function(function) for function in ModelFunction.places.values()]
        super().__init__(0, [ctypes.cast(each, ctypes.c_void_p).value or 0 for each in self._functions])

    def replace(self, content: PythonModelFunctions) -> None:
        """Hold other functions."""
        self.content = content

    def __reduce__(self) -> tuple[Any, ...]:
        return PythonTable, (self.content,)

    def _c_function(self, function: ModelFunction) -> Any:
        def answer(_: int, node: int, *words: int) -> Any:
            try:
                return function(self.content, *_arguments(function, iter(words)))
            except BaseException as failure:  # a KeyboardInterrupt, too, has to reach the caller of the solver
                self.content.failure = failure
                return math.nan

        taken: list[Any] = [ctypes.c_void_p, ctypes.c_int64]
        for kind in function.arguments:
            lengths = [ctypes.c_int64] * kind.ndim if isinstance(kind, types.Array) else []
            taken += [ctypes.c_void_p, *lengths] if lengths else [ctypes.c_int64]
        returns = ctypes.c_double if function.returns is types.float64 else None
        return ctypes.CFUNCTYPE(returns, *taken)(answer)


def _arguments(function: ModelFunction, words: Iterator[int]) -> Iterator[Any]:
    """Numbers, and views of doubles at addresses, as compiled code passes them."""
    for kind in function.arguments:
        first = next(words)
        if isinstance(kind, types.Array):
            shape = [next(words) for _ in range(kind.ndim)]
            memory: Any = (ctypes.c_double * math.prod(shape)).from_address(first or 0)
            yield np.ndarray(shape, buffer=memory)
        else:
            yield first


def _answer(name: str, *wanted: str) -> Callable[..., None]:
    """Kernel in Python: what is wanted of a function, into the arrays behind its arguments."""

    def answer(model: PythonModelFunctions, *arrays: Array) -> None:
        given = arrays[: -len(wanted)]
        for what, out in zip(wanted, arrays[-len(wanted) :], strict=True):
            out[:] = model.result(name, what, given)

    return answer


def _cost(name: str) -> Callable[..., float]:
    return lambda model, *given: float(np.asarray(model.result(name, "values", given)).item())


for _model in (PythonModelFunctions, PythonModelWithCost):
    for _function, _kernel in (
        (functions.step, _answer("step", "values")),
        (functions.linearize_step, _answer("step", "jacobian")),
        (functions.constrain, _answer("constraints", "values")),
        (functions.linearize_constraints, _answer("constraints", "values", "jacobian")),
        (functions.constrain_input, _answer("input_constraints", "values")),
        (functions.linearize_input_constraints, _answer("input_constraints", "values", "jacobian")),
        (functions.constrain_end, _answer("end_constraints", "values")),
        (functions.linearize_end_constraints, _answer("end_constraints", "values", "jacobian")),
        (functions.expand_stage_cost, _answer("stage_cost", "jacobian", "hessian")),
        (functions.expand_end_cost, _answer("end_cost", "jacobian", "hessian")),
    ):
        functions.implement(_function, _model)(_kernel)
functions.implement(functions.stage_cost, PythonModelWithCost)(_cost("stage_cost"))
functions.implement(functions.end_cost, PythonModelWithCost)(_cost("end_cost"))
