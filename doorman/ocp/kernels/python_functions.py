"""Plain Python functions as a problem's functions: checked values, and derivatives by differences or complex steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.exceptions import DimensionError, SolverError

Function = Callable[..., Any]
Method = Literal["differences", "complex step"]

FIRST = 6e-6
"""Relative step of a first difference: the cube root of the rounding error."""
SECOND = 1e-4
"""Relative step of a second difference: its fourth root."""
_TINY = 1e-30
"""Complex steps lose no digits however small they are."""
LARGEST_STATE = 1e6
"""A trajectory with a larger number in a state has diverged, and NaN is no error of the function's there."""


def runge_kutta(derivative: Function, time_step: float, substeps: int = 1) -> Function:
    r"""Discrete step of the classical Runge-Kutta method from a continuous derivative, for plain Python functions.

    .. math::
        x^+ = x + \tfrac{\Delta t}{6}(k_1 + 2k_2 + 2k_3 + k_4),\quad k_1 = \dot x(x, u),\quad
        k_2 = \dot x(x + \tfrac{\Delta t}{2}k_1, u),

        k_3 = \dot x(x + \tfrac{\Delta t}{2}k_2, u),\quad k_4 = \dot x(x + \Delta t\,k_3, u)

    Args:
        derivative: ẋ of x and u, an array or a list of nx numbers.
        time_step: Δt [s].
        substeps: Number of equal steps that make up Δt.

    Returns:
        x⁺ as a function of x and u.

    Raises:
        DimensionError: if the time step or the number of substeps is not positive.
    """
    if not (time_step > 0.0 and substeps >= 1):
        raise DimensionError(
            "not a time step", field="time_step, substeps", given=(time_step, substeps), allowed="> 0, >= 1"
        )
    h = time_step / substeps

    def step(x: Any, u: Any) -> Any:
        for _ in range(substeps):
            k1 = np.asarray(derivative(x, u))
            k2 = np.asarray(derivative(x + 0.5 * h * k1, u))
            k3 = np.asarray(derivative(x + 0.5 * h * k2, u))
            k4 = np.asarray(derivative(x + h * k3, u))
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return x

    return step


class CheckedFunction:
    """A function of a state, or of a state and an input, whose values have to have one shape and be numbers.

    Args:
        function: Called with copies, so that it may keep or change what it gets.
        name: For errors.
        size: Number of values; where it is one, a bare number will do.
        method: How derivatives are taken.
    """

    def __init__(self, function: Function, name: str, size: int, method: Method) -> None:
        self._function, self._name, self._size, self._method = function, name, size, method

    def values(self, *arguments: Array) -> Array:
        """Values, shape (size,)."""
        values = self._evaluate([argument.copy() for argument in arguments])
        if np.iscomplexobj(values):
            raise DimensionError("not real numbers", field=self._name, given=values.tolist(), allowed="real numbers")
        if np.isnan(values).any() and all((np.abs(argument) <= LARGEST_STATE).all() for argument in arguments):
            raise SolverError(
                "returned NaN", field=self._name, given=" and ".join(str(each.tolist()) for each in arguments),
                allowed="arguments for which it has a value; bounds keep solvers away from others",
            )  # fmt: skip
        return values.astype(np.float64)

    def check(self, *arguments: Array) -> None:
        """Check the shape of what the function returns, and its complex steps, where the model wants them, by differences."""
        self._evaluate([argument.copy() for argument in arguments])
        if self._method != "complex step":
            return
        exact, rough = self._by_complex_steps(arguments), self._by_differences(arguments, FIRST)
        largest = np.abs(rough).max(initial=1.0)
        if np.isfinite(rough).all() and not np.allclose(exact, rough, rtol=1e-3, atol=1e-4 * largest):
            raise SolverError(
                "complex steps and differences give different slopes", field=self._name, given=exact.tolist(),
                allowed=f"{rough.tolist()}; a function of complex numbers, or derivatives='differences'",
            )  # fmt: skip

    def jacobian(self, *arguments: Array, reach: float = FIRST) -> Array:
        """Slopes by all entries of the arguments in a row, shape (size, entries)."""
        exact = self._method == "complex step"
        slopes = self._by_complex_steps(arguments) if exact else self._by_differences(arguments, reach)
        if np.isnan(slopes).any():
            raise SolverError("the slope is NaN", field=self._name, given=[each.tolist() for each in arguments])
        return slopes

    def hessian(self, *arguments: Array) -> Array:
        """Second slopes of a single value, the nearest positive semidefinite matrix, shape (entries, entries)."""
        reach = FIRST if self._method == "complex step" else SECOND
        matrix = np.array([
            (self.jacobian(*ahead, reach=SECOND)[0] - self.jacobian(*behind, reach=SECOND)[0]) / (2.0 * step)
            for ahead, behind, step in _shifts(arguments, reach)
        ])  # fmt: skip
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        result: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
        return result

    def _by_complex_steps(self, arguments: Sequence[Array]) -> Array:
        exact = [each.astype(np.complex128) for each in arguments]
        return np.array([self._evaluate(ahead).imag / _TINY for ahead in _shifted(exact, lambda _: 1j * _TINY)]).T

    def _by_differences(self, arguments: Sequence[Array], reach: float) -> Array:
        shifts = _shifts(arguments, reach)
        return np.array([(self.values(*a) - self.values(*b)) / (2.0 * step) for a, b, step in shifts]).T

    def _evaluate(self, arguments: list[Any]) -> NDArray[Any]:
        shape = f"shape ({self._size},)" + (" or one number" if self._size == 1 else "")
        values = numbers(self._function(*arguments), self._name, shape)
        if values.ndim == 0 and self._size == 1:
            values = values.reshape(1)
        if values.shape != (self._size,):
            raise DimensionError("wrong shape", field=self._name, given=values.shape, allowed=shape)
        return values


def count(function: Function, name: str, *arguments: Array) -> int:
    """Number of values that a function returns."""
    returned = function(*(argument.copy() for argument in arguments))
    values = np.atleast_1d(numbers(returned, name, "a vector of numbers"))
    if values.ndim != 1 or not values.size:
        raise DimensionError("wrong shape", field=name, given=values.shape, allowed="a vector of at least one number")
    return values.size


def numbers(returned: Any, name: str, allowed: str) -> NDArray[Any]:
    """What a function has returned, as an array of floats or of complex numbers."""
    try:
        values = np.asarray(returned)
    except ValueError:
        values = np.array(None)
    if values.dtype.kind not in "biufc":
        raise DimensionError("not an array of numbers", field=name, given=repr(returned), allowed=allowed)
    return values.astype(np.complex128 if values.dtype.kind == "c" else np.float64)


def _shifted(arguments: Sequence[NDArray[Any]], step: Callable[[Any], Any]) -> Iterator[list[NDArray[Any]]]:
    """Arguments with one entry moved by a step that depends on it; for every entry."""
    for i, argument in enumerate(arguments):
        for j in range(len(argument)):
            moved = [each.copy() for each in arguments]
            moved[i][j] += step(argument[j])
            yield moved


def _shifts(arguments: Sequence[Array], relative: float) -> Iterator[tuple[list[Array], list[Array], float]]:
    """Arguments with one entry a step ahead, and a step behind, with the length of the step; for every entry."""
    reaches = (relative * (1.0 + abs(entry)) for argument in arguments for entry in argument)
    ahead = _shifted(arguments, lambda entry: relative * (1.0 + abs(entry)))
    behind = _shifted(arguments, lambda entry: -relative * (1.0 + abs(entry)))
    return zip(ahead, behind, map(float, reaches), strict=True)
