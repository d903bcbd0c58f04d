r"""Matrices of Euler rates: :math:`\Omega = W^{-1}(\Phi)\,\dot\Phi`, and of the cross product."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.rotations import body_rates_of


def body_rate_matrix(attitude: ArrayLike) -> Array:
    """Inverse of W, column by column."""
    return body_rates_of(np.tile(np.asarray(attitude, dtype=float), (3, 1)), np.eye(3)).T


def euler_rate_matrix(attitude: ArrayLike) -> Array:
    return np.asarray(np.linalg.inv(body_rate_matrix(attitude)))


def skew(v: ArrayLike) -> Array:
    """Matrix â of the cross product: â b = a × b."""
    return np.asarray(np.cross(np.asarray(v, dtype=float), np.eye(3)).T)
