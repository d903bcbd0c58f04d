"""Arrays of floats, of double precision: their type, and arrays that cannot be written to."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
AnyArray = TypeVar("AnyArray", bound=NDArray[Any])


def sealed(array: AnyArray) -> AnyArray:
    """The same array, from now on read-only."""
    array.flags.writeable = False
    return array


def frozen(values: ArrayLike) -> Array:
    """A copy that cannot be written to."""
    return sealed(np.array(values, dtype=np.float64))
