"""The leaf's shape: the hull of all that its joint carries, with the panel apart from what stands on it, such as a handle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfShape, read_collisions
from doorman.kinematics.urdf.mesh_hull import convex_hull

_PARALLEL = math.cos(math.radians(0.25))
"""Least cosine between the hinge's axis and an edge of the leaf that counts as parallel to it."""
_STANDS_ON = 0.05
"""Share of the area of all parts' largest sides below which parts stand on the leaf, as a handle does: a bar over the whole
height of a door has 0.02, a stile of its frame 0.1."""


@dataclass(frozen=True)
class Part:
    """One collision shape in the joint's frame, as its corners and radius: the hull of balls."""

    link: str
    corners: Array
    """Shape (m, 3) [m]."""
    edges: Array
    """Directions that may be the leaf's, shape (k, 3)."""
    radius: float = 0.0
    """Radius of the balls [m]."""

    def extent(self, direction: Array) -> tuple[float, float]:
        """From where to where it reaches along a unit vector [m]."""
        along = self.corners @ direction
        return float(along.min()) - self.radius, float(along.max()) + self.radius


@dataclass(frozen=True)
class LeafShape:
    """Shape of a leaf on its joint, by unit vector of hinge or slide, (3,). Directions are in the joint's frame."""

    parts: tuple[Part, ...]
    axis: Array

    @cached_property
    def along(self) -> Array | None:
        """Unit vector along a hinged leaf, from the hinge and across its axis; None where nothing stands along the hinge.

        It is that edge of a part along which the whole is thinnest.
        """
        edges = np.vstack([part.edges for part in self.parts])
        upright = np.abs(edges @ self.axis) >= _PARALLEL
        across = edges - np.outer(edges @ self.axis, self.axis)
        length = np.linalg.norm(across, axis=1)
        likely = across[(length >= _PARALLEL) & ~upright] / length[(length >= _PARALLEL) & ~upright, None]
        if not len(likely) or not upright.any():
            return None
        thinnest = min(likely, key=lambda edge: round(self.width(np.cross(self.axis, edge)), 9))
        lower, upper = self.extent(thinnest)
        return np.asarray(thinnest if upper + lower >= 0.0 else -thinnest)

    def extent(self, direction: Array) -> tuple[float, float]:
        """From where to where the leaf reaches along a unit vector, without what stands on it [m]."""
        reaches = np.array([part.extent(direction) for part in self.parts])
        return -self._reach(-reaches[:, 0]), self._reach(reaches[:, 1])

    def width(self, direction: Array) -> float:
        """How far the leaf reaches along a unit vector [m]."""
        lower, upper = self.extent(direction)
        return upper - lower

    def face(self, normal: Array, along: Array, up: Array, place: tuple[float, float]) -> float:
        """Where the leaf's face is along its normal, at a place along and up: a panel may lie behind its frame [m]."""
        front = self.extent(normal)[0]
        there = [
            part.extent(normal)[0]
            for part in self.parts
            if _within(place[0], part.extent(along)) and _within(place[1], part.extent(up))
        ]
        return max(min(there, default=front), front)

    @cached_property
    def _sides(self) -> Array:
        """Area of each part's largest side, shape (m,) [m²]."""
        lengths = [np.sort(np.ptp([part.extent(axis) for axis in np.eye(3)], axis=1)) for part in self.parts]
        return np.array([length[1] * length[2] for length in lengths])

    def _reach(self, reaches: Array) -> float:
        """Where parts begin that are too large, all those beyond included, to stand on the leaf only."""
        order = np.argsort(-reaches)
        covered = np.cumsum(self._sides[order]) >= _STANDS_ON * self._sides.sum()
        return float(reaches[order][int(np.argmax(covered))])


def read_shape(urdf: Path, model: pinocchio.Model, axis: Array, leaf: str) -> LeafShape:
    """All that the only joint of a model carries."""
    placements = {
        frame.name: np.array(frame.placement.homogeneous)
        for frame in model.frames
        if frame.type == pinocchio.FrameType.BODY and frame.parentJoint == 1
    }
    parts = [_part(urdf, shape, placements[shape.link]) for shape in read_collisions(urdf) if shape.link in placements]
    if not parts:
        others = ", ".join(dict.fromkeys(shape.link for shape in read_collisions(urdf))) or "none"
        raise UrdfError(
            "the leaf has no collision shape", file=urdf, field=f"link {leaf}/collision",
            given=f"shapes in {others}, which its joint does not move", allowed="boxes, cylinders or meshes of leaf and handle",
        )  # fmt: skip
    return LeafShape(tuple(parts), axis)


def _part(urdf: Path, shape: UrdfShape, link: Array) -> Part:
    placed = link @ shape.placement
    radius, edges = 0.0, placed[:3, :3].T
    if shape.kind == "box":
        corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * shape.size
    elif shape.kind == "sphere":
        corners, edges, radius = np.zeros((1, 3)), np.empty((0, 3)), shape.size[0]
    elif shape.kind == "cylinder":
        turns = np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)
        ring = shape.size[0] * np.column_stack([np.cos(turns), np.sin(turns)])
        corners = np.vstack([np.column_stack([ring, np.full(len(ring), end * shape.size[1])]) for end in (-0.5, 0.5)])
        edges = placed[:3, 2][None]
    else:
        hull = convex_hull(urdf, shape)
        corners, edges = hull.vertices, _edges(hull.vertices, hull.triangles) @ placed[:3, :3].T
    return Part(shape.link, corners @ placed[:3, :3].T + placed[:3, 3], edges, radius)


def _edges(vertices: Array, triangles: NDArray[np.int64]) -> Array:
    """Unit vectors along the edges of a hull, each direction once."""
    edges = np.vstack([vertices[triangles[:, k]] - vertices[triangles[:, k - 1]] for k in range(3)])
    edges /= np.maximum(np.linalg.norm(edges, axis=1), 1e-12)[:, None]
    leading = np.take_along_axis(edges, np.abs(edges).argmax(axis=1)[:, None], axis=1)
    return np.unique(np.round(edges * np.sign(leading), 6), axis=0)


def _within(value: float, extent: tuple[float, float]) -> bool:
    return extent[0] <= value <= extent[1]
