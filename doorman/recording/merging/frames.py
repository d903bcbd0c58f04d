"""Axes of autopilots' logs: x forward, y right, z down."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def from_forward_right_down(vectors: NDArray[Any]) -> NDArray[np.float64]:
    r"""Vectors in this project's body frame, :math:`(x, -y, -z)`."""
    with np.errstate(invalid="ignore"):  # NaN of single precision stays NaN
        return np.asarray(vectors * np.array([1.0, -1.0, -1.0]))
