"""Meshes for tests: surfaces of boxes, and binary STL of any triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
"""Of a box, by its corners in binary."""
Box = tuple[ArrayLike, ArrayLike]
"""Centre and lengths."""
TETRAHEDRON = [[(0, 0, 0), (0, 1, 0), (1, 0, 0)], [(0, 0, 0), (1, 0, 0), (0, 0, 1)], [(0, 0, 0), (0, 0, 1), (0, 1, 0)],
               [(1, 0, 0), (0, 1, 0), (0, 0, 1)]]  # fmt: skip


def stl_of_boxes(*boxes: Box) -> bytes:
    """Binary STL of all boxes' surfaces."""
    unit = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)]) - 0.5
    corners = [np.asarray(center) + unit * np.asarray(size) for center, size in boxes]
    return stl([box[list(three)] for box in corners for a, b, c, d in FACES for three in ((a, b, c), (a, c, d))])


def stl(triangles: Sequence[ArrayLike]) -> bytes:
    """Binary STL of triangles, shape (k, 3, 3)."""
    body = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    body["v"] = np.reshape(np.asarray(triangles, dtype=float), (-1, 3, 3))
    return bytes(80) + np.uint32(len(triangles)).tobytes() + body.tobytes()
