"""What solvers are given, checked; and what they hand out, so that nobody writes to it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import number, numbers, whole
from doorman.exceptions import DimensionError

Array = NDArray[np.float64]


def checked_budget(max_iterations: int, time_limit: float) -> int:
    """Number of iterations as kernels take it, after a check of both budgets.

    Args:
        max_iterations: Positive integer.
        time_limit: [s], ∞ without a limit.

    Raises:
        DimensionError: if it is no integer, or a budget is not positive.
    """
    if time_limit != math.inf and number(time_limit, "time_limit", "> 0 s") <= 0.0:
        raise DimensionError("not a time limit", field="time_limit", given=time_limit, allowed="> 0 s")
    return whole(max_iterations, "max_iterations", 1)


def copy_checked(field: str, values: ArrayLike, out: Array) -> None:
    """Copy finite numbers into an array of their shape.

    Args:
        field: Name of the argument, for the error.
        values: Numbers.
        out: Filled.

    Raises:
        DimensionError: if the shape is another, or a number is not finite.
    """
    given = numbers(values, field)
    if given.shape != out.shape:
        raise DimensionError("wrong shape", field=field, given=given.shape, allowed=str(out.shape))
    if not np.isfinite(given).all():
        raise DimensionError("not finite", field=field, allowed="finite numbers")
    out[:] = given


def read_only(array: Array) -> Array:
    """A copy that cannot be written to.

    Args:
        array: Of any shape.

    Returns:
        In the array's shape.
    """
    copy = array.copy()
    copy.setflags(write=False)
    return copy
