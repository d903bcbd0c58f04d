"""Lower bounds of the distances between shapes, from their boxes and bounding spheres: what is far need not be measured."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array

Indices = NDArray[np.int64]


class PairBounds(NamedTuple):
    """Pairs of shapes whose distance is bounded from below."""

    first: Indices
    """First shape of each pair, shape (n_pairs,)."""
    second: Indices
    """Second shape of each pair, shape (n_pairs,)."""
    extents: Array
    """Half extents of each shape's box, in the shape's frame, shape (n_shapes, 3) [m]."""
    radii: Array
    """Radius of each shape's bounding sphere, shape (n_shapes,) [m]."""

    def at(self, placements: Array) -> Array:
        """Bounds at m configurations."""
        centers, rotations = placements[:, :, :3, 3], placements[:, :, :3, :3]
        apart = centers[:, self.first] - centers[:, self.second]
        turned = np.abs(np.swapaxes(rotations[:, self.first], 2, 3) @ rotations[:, self.second])
        bounds = np.full(apart.shape[:2], -np.inf)
        for box, other, axes in (
            (self.first, self.second, turned),
            (self.second, self.first, np.swapaxes(turned, 2, 3)),
        ):
            local = np.abs(np.einsum("mkij,mki->mkj", rotations[:, box], apart)) - self.extents[box]
            from_ball = np.linalg.norm(np.maximum(local, 0.0), axis=2) - self.radii[other]
            gaps = local - np.einsum("mkij,kj->mki", axes, self.extents[other])
            bounds = np.maximum(bounds, np.maximum(from_ball, gaps.max(axis=2)))
        return bounds
