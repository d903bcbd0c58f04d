"""What stands beside a doorway: shapes of a door's URDF that do not move with the leaf, as boxes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.kinematics.urdf.elements import read_collisions
from doorman.kinematics.urdf.mesh_hull import bounding_box

_OVERLAP, _BORDER = 0.05, 0.3
"""A box borders on a doorway that reaches over its edge by less than the first, and is farther by less than the second [m]."""


@dataclass(frozen=True, eq=False)
class Box:
    """What does not move with the leaf, as its extent along three axes, such as `into`, `along` and `up` from P_h."""

    center: Array
    """Shape (3,) [m]."""
    half: Array
    """Shape (3,) [m]."""

    @property
    def front(self) -> float:
        return float(self.center[0] - self.half[0])

    @property
    def ends(self) -> tuple[float, float]:
        """Along the second axis."""
        return float(self.center[1] - self.half[1]), float(self.center[1] + self.half[1])


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
            center, size = bounding_box(urdf, shape)
            placed = placements[shape.link] @ shape.placement
            placed[:3, 3] += placed[:3, :3] @ center
            yield placed, size


def boxes_along(boxes: Iterable[tuple[Array, Array]], axes: Array, origin: Array) -> list[Box]:
    """Extents of boxes along axes, the rows of (3, 3), from a place in the world."""
    return [Box(axes @ (placed[:3, 3] - origin), np.abs(axes @ placed[:3, :3]) @ size / 2) for placed, size in boxes]


def depth_beside(boxes: Iterable[Box], size: tuple[float, float], upright: bool) -> tuple[float, float]:
    """How far boxes beside the doorway, along its axes from P_h, reach before and behind the hinge axis [m]."""
    beside = [box for box in boxes if _is_beside(box, size, upright)]
    back = max((float(box.center[0] + box.half[0]) for box in beside), default=0.0)
    return -min([0.0, *(box.front for box in beside)]), max(back, 0.0)


def height_below_lintel(boxes: Iterable[Box], size: tuple[float, float]) -> float | None:
    """Height of an upright door's opening, from the leaf's lower edge to the lowest box over it; None without one [m]."""
    lowest = (float(box.center[2] - box.half[2]) for box in boxes if not _is_beside(box, size, upright=True))
    return min((low for low in lowest if low > 0.5 * size[1]), default=None)


def _is_beside(box: Box, size: tuple[float, float], upright: bool) -> bool:
    """Whether a box is beside the doorway: of an upright door all that does not span it, else what borders on it."""
    if upright:
        return bool(abs(box.center[1] - 0.5 * size[0]) > box.half[1])
    middle = 0.5 * np.array(size)
    gap = float((np.abs(box.center[1:] - middle) - box.half[1:] - middle).max())
    return -_OVERLAP < gap < _BORDER
