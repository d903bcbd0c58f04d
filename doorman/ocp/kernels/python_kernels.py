"""Kernels that call back into Python: what makes plain Python functions a model for the compiled solvers.

Kernels reach the C function of a `Callback` by its address, a number in the model. They hold no lock; `ctypes` takes the GIL
for each call. No exception gets through compiled code: the callback keeps it, answers NaN from then on, so that the solver
ends soon, and the solver raises it.
"""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.callbacks import C_FUNCTION, call
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.python_functions import CheckedFunction

_STEP, _STEP_SLOPES, _ROWS, _ROW_SLOPES, _INPUT_ROWS, _INPUT_ROW_SLOPES = range(6)
_END_ROWS, _END_ROW_SLOPES, _STAGE_COST, _STAGE_EXPANSION, _END_COST, _END_EXPANSION = range(6, 12)

_TASKS = {
    _STEP: ("step", True, "values"),
    _STEP_SLOPES: ("step", True, "slopes"),
    _ROWS: ("constraints", False, "values"),
    _ROW_SLOPES: ("constraints", False, "values and slopes"),
    _INPUT_ROWS: ("input_constraints", True, "values"),
    _INPUT_ROW_SLOPES: ("input_constraints", True, "values and slopes"),
    _END_ROWS: ("end_constraints", False, "values"),
    _END_ROW_SLOPES: ("end_constraints", False, "values and slopes"),
    _STAGE_COST: ("stage_cost", True, "values"),
    _STAGE_EXPANSION: ("stage_cost", True, "expansion"),
    _END_COST: ("end_cost", False, "values"),
    _END_EXPANSION: ("end_cost", False, "expansion"),
}
"""Function, whether it has an input for an argument, and the requested derivatives."""


class Callback:
    """The C function that kernels call, and what the Python functions behind it have raised.

    Args:
        checked: The functions, by name.
        nx: Number of states.
        nu: Number of inputs.
    """

    def __init__(self, checked: dict[str, CheckedFunction], nx: int, nu: int) -> None:
        self.checked = checked
        self.failure: BaseException | None = None
        self._nx, self._nu = nx, nu
        self._function = C_FUNCTION(self._answer)
        self.address = ctypes.cast(self._function, ctypes.c_void_p).value or 0

    def separate(self) -> Callback:
        """Another C function of the same Python functions."""
        return Callback(self.checked, self._nx, self._nu)

    def __reduce__(self) -> tuple[Any, ...]:
        return Callback, (self.checked, self._nx, self._nu)

    def _answer(self, task: int, x: int, u: int, out: int, slopes: int) -> None:
        name, with_input, wanted = _TASKS[task]
        arguments = [_view(x, self._nx), _view(u, self._nu)] if with_input else [_view(x, self._nx)]
        entries = self._nx + self._nu if with_input else self._nx
        rows = self.checked[name].size if name in self.checked else 1
        if wanted == "expansion":
            outputs = [_view(out, entries), _view(slopes, entries * entries)]
        else:
            outputs = [_view(out, rows)] if wanted.startswith("values") else []
            outputs += [_view(slopes, rows * entries)] if wanted.endswith("slopes") else []
        for output, result in zip(outputs, self._results(name, wanted, arguments), strict=False):
            output[:] = result

    def _results(self, name: str, wanted: str, arguments: list[Array]) -> list[Any]:
        nothing, function = [np.nan, np.nan], self.checked.get(name)
        if function is None:
            return [0.0, 0.0]
        if self.failure is not None or not all(np.isfinite(argument).all() for argument in arguments):
            return nothing
        try:
            if wanted == "expansion":
                return [function.jacobian(*arguments).ravel(), function.hessian(*arguments).ravel()]
            values = [function(*arguments)] if wanted.startswith("values") else []
            return values + ([function.jacobian(*arguments).ravel()] if wanted.endswith("slopes") else [])
        except BaseException as failure:  # a KeyboardInterrupt, too, has to reach the caller of the solver
            self.failure = failure
            return nothing


class _Address(NamedTuple):
    address: int
    """Address of the C function."""


class PythonKernels(_Address):
    """The model for the solvers: for kernels an address, for Python also what lives there."""

    callback: Callback

    def _separate(self) -> PythonKernels:
        """A model of these functions, with failures of its own."""
        return kernels_of(self.callback.separate())

    def __reduce__(self) -> tuple[Any, ...]:
        return kernels_of, (self.callback,)

    def forget_failures(self) -> None:
        """Forget what a function has raised."""
        self.callback.failure = None

    def raise_failure(self) -> None:
        """Raise what a function has raised, once."""
        failure, self.callback.failure = self.callback.failure, None
        if failure is not None:
            raise failure


class PythonKernelsWithCost(PythonKernels):
    """Kernels with a cost of their own: another type, as these ask for the cost."""


def kernels_of(callback: Callback) -> PythonKernels:
    """Model for the compiled solvers that keeps a callback alive."""
    own_cost = "stage_cost" in callback.checked or "end_cost" in callback.checked
    model = (PythonKernelsWithCost if own_cost else PythonKernels)(callback.address)
    model.callback = callback
    return model


def _view(address: int, size: int) -> Array:
    """Doubles at an address."""
    memory: Any = (ctypes.c_double * size).from_address(address)
    return np.frombuffer(memory, dtype=np.float64)


@functions.implement(functions.step, PythonKernels)
@functions.implement(functions.step, PythonKernelsWithCost)
@kernel
def _step(model: Any, x: Array, u: Array, out: Array) -> None:
    call(model.address, _STEP, x, u, out, out)


@functions.implement(functions.linearize_step, PythonKernels)
@functions.implement(functions.linearize_step, PythonKernelsWithCost)
@kernel
def _linearize_step(model: Any, x: Array, u: Array, jacobian: Array) -> None:
    call(model.address, _STEP_SLOPES, x, u, jacobian, jacobian)


@functions.implement(functions.constrain, PythonKernels)
@functions.implement(functions.constrain, PythonKernelsWithCost)
@kernel
def _constrain(model: Any, x: Array, h: Array) -> None:
    call(model.address, _ROWS, x, x, h, h)


@functions.implement(functions.linearize_constraints, PythonKernels)
@functions.implement(functions.linearize_constraints, PythonKernelsWithCost)
@kernel
def _linearize_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    call(model.address, _ROW_SLOPES, x, x, h, jacobian)


@functions.implement(functions.constrain_input, PythonKernels)
@functions.implement(functions.constrain_input, PythonKernelsWithCost)
@kernel
def _constrain_input(model: Any, x: Array, u: Array, g: Array) -> None:
    call(model.address, _INPUT_ROWS, x, u, g, g)


@functions.implement(functions.linearize_input_constraints, PythonKernels)
@functions.implement(functions.linearize_input_constraints, PythonKernelsWithCost)
@kernel
def _linearize_input_constraints(model: Any, x: Array, u: Array, g: Array, jacobian: Array) -> None:
    call(model.address, _INPUT_ROW_SLOPES, x, u, g, jacobian)


@functions.implement(functions.constrain_end, PythonKernels)
@functions.implement(functions.constrain_end, PythonKernelsWithCost)
@kernel
def _constrain_end(model: Any, x: Array, h: Array) -> None:
    call(model.address, _END_ROWS, x, x, h, h)


@functions.implement(functions.linearize_end_constraints, PythonKernels)
@functions.implement(functions.linearize_end_constraints, PythonKernelsWithCost)
@kernel
def _linearize_end_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    call(model.address, _END_ROW_SLOPES, x, x, h, jacobian)


@functions.implement(functions.stage_cost, PythonKernelsWithCost)
@kernel
def _stage_cost(model: Any, x: Array, u: Array) -> float:
    value = np.empty(1)
    call(model.address, _STAGE_COST, x, u, value, value)
    return float(value[0])


@functions.implement(functions.expand_stage_cost, PythonKernelsWithCost)
@kernel
def _expand_stage_cost(model: Any, x: Array, u: Array, gradient: Array, hessian: Array) -> None:
    call(model.address, _STAGE_EXPANSION, x, u, gradient, hessian)


@functions.implement(functions.end_cost, PythonKernelsWithCost)
@kernel
def _end_cost(model: Any, x: Array) -> float:
    value = np.empty(1)
    call(model.address, _END_COST, x, x, value, value)
    return float(value[0])


@functions.implement(functions.expand_end_cost, PythonKernelsWithCost)
@kernel
def _expand_end_cost(model: Any, x: Array, gradient: Array, hessian: Array) -> None:
    call(model.address, _END_EXPANSION, x, x, gradient, hessian)
