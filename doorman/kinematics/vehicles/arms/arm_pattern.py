"""The arm as constants of its zero configuration: which of them are plain zeros and ones, and which are numbers.

Arms of one pattern share kernels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array

Entry = int | float
"""A float is that constant; an integer the index of a number."""
Rows = tuple[tuple[Entry, Entry, Entry], ...]

_ROUNDING = 1e-15


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


@dataclass(frozen=True)
class ArmPattern:
    """Constants of `ArmGeometry`: plain ones in place, the others by their index."""

    axes: Rows
    """Axes of the joints at H = 0, one row each."""
    links: Rows
    """From joint to joint."""
    slides: tuple[bool, ...]
    """Which joints are prismatic."""
    parents: tuple[int, ...]
    """Joint that carries each point."""
    offsets: Rows
    """Place of each point on its joint."""
    above: bool
    """Whether the arm belongs above the rotors' plane."""

    @classmethod
    def of(cls, arm: ArmGeometry) -> tuple[ArmPattern, Array]:
        """Pattern of an arm, and its numbers in order."""
        numbers: list[float] = []

        def rows(values: Array) -> Rows:
            return tuple((entry(row[0]), entry(row[1]), entry(row[2])) for row in values)

        def entry(value: float) -> Entry:
            for plain in (0.0, 1.0, -1.0):
                if abs(value - plain) < _ROUNDING:
                    return plain
            numbers.append(float(value))
            return len(numbers) - 1

        axes, links, offsets = rows(arm.axes), rows(arm.links), rows(arm.point_offsets)
        slides, parents = tuple(bool(each) for each in arm.slides), tuple(int(parent) for parent in arm.point_parents)
        return cls(axes, links, slides, parents, offsets, arm.above), np.array(numbers)

    @property
    def n_joints(self) -> int:
        """N."""
        return len(self.axes)
