"""Checks of a solver's inputs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import number, numbers, vector, whole
from doorman.exceptions import DimensionError
from doorman.ocp.problem.problem import Problem


def checked_budget(max_iterations: int, time_limit: float) -> int:
    """Number of iterations as kernels take it, after a check of both budgets."""
    if time_limit != math.inf and number(time_limit, "time_limit", "> 0 s") <= 0.0:
        raise DimensionError("not a time limit", field="time_limit", given=time_limit, allowed="> 0 s")
    return whole(max_iterations, "max_iterations", 1)


def checked_state(state: ArrayLike, problem: Problem, field: str = "state") -> Array:
    """A first state as kernels take it: where the duration is free with a stretch, which acts on nothing there."""
    given = vector(state, problem.given_states, field)
    return given if problem.free_time is None else np.append(given, 1.0)


def copy_checked(field: str, values: ArrayLike, out: Array) -> None:
    """Copy finite numbers into an array of their shape."""
    given = numbers(values, field)
    if given.shape != out.shape:
        raise DimensionError("wrong shape", field=field, given=given.shape, allowed=str(out.shape))
    if not np.isfinite(given).all():
        raise DimensionError("not finite", field=field, allowed="finite numbers")
    out[:] = given
