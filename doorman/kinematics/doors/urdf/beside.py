"""What stands beside a doorway: shapes of a door's URDF that do not move with the leaf, as boxes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.kinematics.doors.urdf.convention import FixedBox
from doorman.kinematics.doors.urdf.leaf_shape import oriented_box
from doorman.kinematics.urdf.shapes import read_collisions

_OVERLAP, _BORDER = 0.05, 0.3
"""A box borders on a doorway that reaches over its edge by less than the first, and is farther by less than the second [m]."""


def fixed_boxes(urdf: Path, model: pinocchio.Model) -> Iterator[tuple[Array, Array]]:
    """Placement, (4, 4), and lengths, (3,), of what does not move with the leaf."""
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, np.zeros(1))
    placements = {
        frame.name: np.array(placement.homogeneous)
        for frame, placement in zip(model.frames, data.oMf, strict=True)
        if frame.type == pinocchio.FrameType.BODY and frame.parentJoint != 1
    }
    for shape in read_collisions(urdf):
        if shape.link in placements:
            placed, size = oriented_box(urdf, shape)
            yield placements[shape.link] @ placed, size


def extents(boxes: Iterable[tuple[Array, Array]]) -> list[FixedBox]:
    """Extents of boxes along the world's axes."""
    return [FixedBox(placed[:3, 3], np.abs(placed[:3, :3]) @ size / 2) for placed, size in boxes]


def depth_beside(
    boxes: Iterable[tuple[Array, Array]], axes: Array, corner: Array, size: tuple[float, float], upright: bool
) -> tuple[float, float]:
    """How far boxes beside the doorway reach before and behind the hinge axis [m]."""
    nearest, farthest = [0.0], [0.0]
    for placed, lengths in boxes:
        center = axes @ (placed[:3, 3] - corner)
        half = np.abs(axes @ placed[:3, :3]) @ lengths / 2
        if _is_beside(center, half, size, upright):
            nearest.append(float(center[0] - half[0]))
            farthest.append(float(center[0] + half[0]))
    return -min(nearest), max(farthest)


def height_below_lintel(
    boxes: Iterable[tuple[Array, Array]], axes: Array, corner: Array, size: tuple[float, float]
) -> float | None:
    """Height of an upright door's opening, from the leaf's lower edge to the lowest box over it; None without one [m]."""
    over = []
    for placed, lengths in boxes:
        center = axes @ (placed[:3, 3] - corner)
        half = np.abs(axes @ placed[:3, :3]) @ lengths / 2
        if not _is_beside(center, half, size, upright=True) and center[2] - half[2] > 0.5 * size[1]:
            over.append(float(center[2] - half[2]))
    return min(over, default=None)


def _is_beside(center: Array, half: Array, size: tuple[float, float], upright: bool) -> bool:
    """Whether a box is beside the doorway: of an upright door all that does not span it, else what borders on it."""
    if upright:
        return bool(abs(center[1] - 0.5 * size[0]) > half[1])
    middle = 0.5 * np.array(size)
    gap = float((np.abs(center[1:] - middle) - half[1:] - middle).max())
    return -_OVERLAP < gap < _BORDER
