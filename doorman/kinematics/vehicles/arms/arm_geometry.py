"""The arm as constants of its zero configuration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array


@dataclass(frozen=True)
class ArmGeometry:
    """The arm as constants of its zero configuration, in body axes; enough to compute every point without Pinocchio.

    With R_0 = I and R_i = R_{i−1} Rot(axis_i, η_i): joint i+1 lies R_i link_{i+1} after joint i, and a point of parent i
    lies R_i offset after joint i (parent −1: the body itself, offsets from O_B). A joint that slides does not turn what it
    carries, R_i = R_{i−1}, and lies R_i axis_i η_i farther.
    """

    axes: Array
    """Joint axes at H = 0, shape (n, 3)."""
    links: Array
    """Vector from joint i−1 (from O_B for the first) to joint i at H = 0, shape (n, 3) [m]."""
    slides: NDArray[np.bool_]
    """Whether a joint is prismatic, shape (n,)."""
    point_parents: NDArray[np.int64]
    """Index of the joint that carries each constrained point, shape (n_points,)."""
    point_offsets: Array
    """Vector from that joint to the point at H = 0, shape (n_points, 3) [m]."""
    above: bool
    """Whether the arm belongs above the rotors' plane, and not below it."""
