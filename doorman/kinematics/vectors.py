"""Vectors of three floats as tuples, for kernels: nothing is allocated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Vector = tuple[float, float, float]


@kernel
def dot(a: Vector, b: Vector) -> float:
    """Inner product aᵀb."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Cross product a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def scale(s: float, a: Vector) -> Vector:
    """Product s a."""
    return s * a[0], s * a[1], s * a[2]


@kernel
def combine(s: float, a: Vector, t: float, b: Vector) -> Vector:
    """Linear combination s a + t b."""
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@kernel
def transform(m: NDArray[np.float64], a: Vector) -> Vector:
    """Product of the (3, 3) matrix m and a."""
    return dot((m[0, 0], m[0, 1], m[0, 2]), a), dot((m[1, 0], m[1, 1], m[1, 2]), a), dot((m[2, 0], m[2, 1], m[2, 2]), a)
