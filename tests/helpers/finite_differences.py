"""Central differences, against which every derivative is checked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def central_difference(function: Callable[[Array], Array], at: Array, step: float = 1e-6) -> Array:
    """Jacobian of a function of one vector; its columns are on the last axis of the result."""
    columns = []
    for axis in np.eye(len(at)):
        ahead, behind = (np.asarray(function(at + sign * step * axis), dtype=np.float64) for sign in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step))
    return np.stack(columns, axis=-1)
