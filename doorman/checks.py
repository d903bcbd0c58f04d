"""Checks of arrays that come from outside: shape, type and finiteness."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.exceptions import DimensionError


def vector(values: ArrayLike, size: int, field: str) -> NDArray[np.float64]:
    """A fresh float vector of the right length with finite entries.

    Args:
        values: What was given.
        size: Length that is needed.
        field: Name of the argument, for the error.

    Returns:
        Shape (size,).

    Raises:
        DimensionError: if the values are not numbers, have another shape, or are not all finite.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DimensionError(
            "not an array of numbers", field=field, given=repr(values)[:80], allowed=f"shape ({size},)"
        ) from error
    if array.shape != (size,):
        raise DimensionError("wrong shape", field=field, given=array.shape, allowed=f"({size},)")
    if not all(map(math.isfinite, array.tolist())):  # faster than numpy's for short vectors
        index = int(np.flatnonzero(~np.isfinite(array))[0])
        raise DimensionError(
            "not finite", field=f"{field}[{index}]", given=float(array[index]), allowed="finite numbers"
        )
    return array
