"""The package without a compiler: every kernel runs as the plain Python function that it is written as.

numba compiles nothing. What has no Python body, as its machine code is written by hand (rows of numbers in registers, one node of
the Riccati sweep, the marking of active rows), gets a plain body here from its docstring's formula; for themselves these
are compared with dense algebra in tests/numba_types and tests/ocp. Python checks every index, which compiled code does not.

To be imported before anything of the package.
"""

from __future__ import annotations

import copy
import ctypes
import functools
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman import compilation
from doorman.numba_types import clock as clocks
from doorman.numba_types import elementary, function_tables, lanes, matrix_rows

Array = NDArray[Any]

np.seterr(all="ignore")  # IEEE, as in kernels

called: dict[str, int] = {}
"""How often every kernel that was defined has run, by module and name."""


def _kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    name = f"{function.__module__}.{function.__qualname__}"
    called.setdefault(name, 0)

    @functools.wraps(function)
    def plain(*arguments: Any) -> Any:
        called[name] += 1
        return function(*arguments)

    return plain


class Row(np.ndarray):
    """Some consecutive numbers as a value: operators make new ones."""

    def __iadd__(self, other: Any) -> Any:
        return self + other

    def __isub__(self, other: Any) -> Any:
        return self - other

    def __imul__(self, other: Any) -> Any:
        return self * other

    def __itruediv__(self, other: Any) -> Any:
        return self / other


def _numbers(array: Array, index: Any, width: int) -> Array:
    """A view of so many numbers of one row from an index on."""
    *rows, first = index if isinstance(index, tuple) else (index,)
    row = array[tuple(rows)]
    assert row.ndim == 1 and 0 <= first and first + width <= len(row), "beyond the row"
    return row[first : first + width]


def load(array: Array, index: Any, width: tuple[int, ...]) -> Any:
    return _numbers(array, index, len(width)).copy().view(Row)


def store(array: Array, index: Any, value: Any) -> None:
    _numbers(array, index, len(value))[:] = value


def get(array: Array, index: Any, width: tuple[int, ...]) -> Any:
    if not width:
        return array[index]
    return load(array, (*(index if isinstance(index, tuple) else (index,)), 0), width)


def put(array: Array, index: Any, value: Any) -> None:
    if isinstance(value, Row):
        store(array, (*(index if isinstance(index, tuple) else (index,)), 0), value)
    else:
        assert np.ndim(array[index]) == 0 and np.ndim(value) == 0
        array[index] = value


def zero(width: tuple[int, ...]) -> Any:
    return np.zeros(len(width)).view(Row) if width else 0.0


def multiply_rows(
    matrix: Array,
    block: int,
    count: tuple[int, ...] | int,
    width: tuple[int, ...],
    vector: Array,
    out: Array,
    start: int,
) -> None:
    rows = count if isinstance(count, int) else len(count)
    out[start : start + rows] = matrix[block, :rows, : len(width)] @ vector[: len(width)]


def call(address: int, task: int, x: Array, u: Array, out: Array, slopes: Array) -> None:
    pointers = (each.ctypes.data_as(ctypes.c_void_p) for each in (x, u, out, slopes))
    from doorman.numba_types import callbacks

    callbacks.C_FUNCTION(address)(task, *pointers)  # type: ignore[call-overload]


class Handle:
    """A NamedTuple; kernels read its fields as they would those of a handle."""

    def __init__(self, content: Any) -> None:
        self.content = content

    def replace(self, content: Any) -> None:
        self.content = content

    def __reduce__(self) -> tuple[Any, ...]:
        return Handle, (copy.deepcopy(self.content),)  # arrays of its own

    def __getattr__(self, name: str) -> Any:
        return getattr(self.content, name)


def mark_bounds(
    node: int, count: tuple[int, ...], values: Array, lower: Array, upper: Array, multipliers: Array, scale: float,
    active: Array, proposal: Array,
) -> tuple[int, bool]:  # fmt: skip
    above, below = (multipliers[node] + scale * (values[: len(count)] - end) for end in (upper, lower))
    return _mark(above, np.minimum(below, 0.0), active[node], proposal[node])


def _mark(above: Array, below: Array, active: Array, proposal: Array) -> tuple[int, bool]:
    sides = (above > 0.0).astype(np.int8) - (below < 0.0).astype(np.int8)
    changed = bool((sides != active).any())
    active[:], proposal[:] = sides, np.maximum(above, 0.0) + below
    return int(np.abs(sides).sum()), changed


def eliminate_inputs(
    sizes: Any, node: int, time_step: float, jacobians: Array, value: Array, base_x: Array, base_u: Array, gains: Array,
    factors: Array, values: Array, rows: Array, scaled: Array,
) -> bool:  # fmt: skip
    nx, nu, m = len(sizes.states), len(sizes.inputs), len(sizes.integrators)
    s, v = nx - m, nu - m
    by_state, defect, by_input = np.split(jacobians[node, :, : nx + 1 + nu].copy(), [nx, nx + 1], axis=1)
    by_state[s:], defect[s:], by_input[s:] = np.eye(m, nx, s), 0.0, np.eye(m, nu, v) * time_step
    by_input[:s, v:], by_state[:s, s:] = 0.0, 0.0
    hessian, gradient = value[:, :nx], value[:, nx : nx + 1]
    ahead = np.hstack([hessian @ by_state, hessian @ defect + gradient])
    state_rows = base_x[:, : nx + 1] + by_state.T @ ahead
    input_rows = base_u[:, : nx + 1 + nu] + by_input.T @ np.hstack([ahead, hessian @ by_input])
    pivots = np.empty(nu)
    for a in range(nu):
        pivots[a] = input_rows[a, nx + 1 + a]
        for c in range(a + 1, nu):
            input_rows[c] -= input_rows[a, nx + 1 + c] / pivots[a] * input_rows[a]
    unit = input_rows / pivots[:, None]
    rows[:, : nx + 1 + nu], scaled[:, : nx + 1 + nu] = input_rows, unit
    factors[node, :, :nu] = np.triu(unit[:, nx + 1 :], 1) + np.diag(pivots)
    state_rows -= input_rows[:, :nx].T @ unit[:, : nx + 1]
    value[:, : nx + 1] = values[node, :, : nx + 1] = state_rows
    gains[node, :, : nx + 1] = -np.linalg.solve(np.triu(unit[:, nx + 1 :]), unit[:, : nx + 1])
    return bool((pivots > 1e-14).all())


def larger(x: Any, y: Any) -> Any:
    return np.where(np.less(x, y), y, x).view(Row) if isinstance(x + y, Row) else (y if x < y else x)


def clock() -> float:
    return time.monotonic()


def with_number(table: Any, number: int) -> Any:
    """Nothing has a table here."""


def taught(name: str, place: int, returns: Any) -> Callable[..., Any]:
    """The table's function itself; what stands for the table is the sizes that it was made for."""
    return lambda shape, *others: sized._entries[place][0](shape, *others)


def _write(handle: Any, content: Any) -> None:
    """Nothing to write: a plain handle has its NamedTuple."""


def _lines(function: Callable[..., Any]) -> Callable[..., Any]:
    """A straight kernel, whose words nobody imports."""
    words = {name: vars(elementary)[name] for name in elementary.INSTRUCTIONS}
    words |= {name: vars(lane_functions)[name] for name in _LANE_FUNCTIONS}
    function.__globals__.update(get=get, put=put, zero=zero, **words)
    return _kernel(function)


def _builtin(generate: Callable[..., Any]) -> Any:
    return _BODIES.get(generate.__name__)  # those of `lane_functions` are put in below


def _of_numbers(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of numpy's on numbers or rows of them."""

    def body(*values: Any) -> Any:
        result = np.asarray(function(*values), dtype=np.float64)
        return result.view(Row) if result.ndim else float(result)

    return body


_LANE_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "smaller": lambda x, y: np.where(np.greater(x, y), y, x), "sign": np.sign,
    "kept_if": lambda condition, x: np.where(np.not_equal(condition, 0.0), x, 0.0),
    "absolute": np.abs, "rounded_down": np.floor, "rounded_up": np.ceil, "with_sign_of": np.copysign,
    "less": np.less, "less_or_equal": np.less_equal, "equal": np.equal, "different": np.not_equal,
    "negated": np.logical_not, "both": np.logical_and, "either": np.logical_or,
    "exponential": np.exp, "exponential_less_one": np.expm1, "logarithm": np.log, "logarithm_of_more_than_one": np.log1p,
    "power": np.power, "hypotenuse": np.hypot, "remainder": np.fmod, "error_function": np.vectorize(math.erf),
    "tangent": np.tan, "arcsine": np.arcsin, "arccosine": np.arccos, "arctangent": np.arctan, "angle_of": np.arctan2,
    "hyperbolic_sine": np.sinh, "hyperbolic_cosine": np.cosh, "area_sine": np.arcsinh, "area_cosine": np.arccosh,
    "area_tangent": np.arctanh,
}  # fmt: skip


_BODIES = {body.__name__: body for body in (call, _write, with_number, mark_bounds, eliminate_inputs)}
compilation.kernel = _kernel  # type: ignore[assignment]
lanes.builtin = _builtin
for _body in (load, store, get, put, zero):
    setattr(lanes, _body.__name__, _body)
elementary.larger, matrix_rows.multiply_rows, clocks.clock = larger, multiply_rows, clock  # type: ignore[assignment]
function_tables.taught = taught

from doorman.numba_types import handles, lane_functions, straight  # noqa: E402

for _name, _function in _LANE_FUNCTIONS.items():
    setattr(lane_functions, _name, _of_numbers(_function))
straight.straight = _lines
handles.Handle, handles.held = Handle, Handle  # type: ignore[misc,assignment]

from doorman.ocp.kernels import compiled_model  # noqa: E402
from doorman.ocp.solvers.sweeps import sized  # noqa: E402

sized.sized_table = lambda sizes, workspace: sized.shape_of(sizes)
compiled_model.CompiledModel = lambda content, names: Handle(content)  # type: ignore[misc,assignment]
