"""Which constants of an arm's geometry are plain zeros and ones, and which are numbers: arms of one pattern share kernels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.vehicles.arms.arm_geometry import ArmGeometry

Entry = int | float
"""A float is that constant; an integer the index of a number."""
Rows = tuple[tuple[Entry, Entry, Entry], ...]

_PLAIN = (0.0, 1.0, -1.0)
_ROUNDING = 1e-15


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
            for plain in _PLAIN:
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
