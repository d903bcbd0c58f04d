"""Convex hull of a mesh: one reader and one shape for FCL, coal and MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import coal
import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array, frozen
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfShape
from doorman.kinematics.urdf.mesh_files import mesh_path
from doorman.kinematics.urdf.structure import LARGEST_LENGTH, LOST

LARGEST_SHAPE = 20_000_000
"""Largest file of a mesh that is a collision shape [bytes]: an STL file with a million vertices, which takes seconds to read."""
MOST_VERTICES = 1_000_000


@dataclass(frozen=True)
class Hull:
    """Convex hull of a mesh, in the frame of its shape."""

    vertices: Array
    """Shape (m, 3) [m]."""
    triangles: NDArray[np.int64]
    """Indices of the vertices, counter-clockwise seen from outside, shape (k, 3)."""


def mesh_vertices(urdf: Path, shape: UrdfShape) -> Array:
    """Vertices of a mesh, its scale applied."""
    file = mesh_path(urdf, shape.file, shape.field)
    if not file.is_file():
        raise UrdfError("no such mesh", file=urdf, field=shape.field, given=shape.file, allowed="an existing file")
    if not 0 < (size := file.stat().st_size) <= LARGEST_SHAPE:
        raise _unreadable(urdf, shape, f"{size} bytes, of 1 to {LARGEST_SHAPE}")
    try:
        vertices = _load(str(file), file.stat().st_mtime_ns, shape.size)
    except (ValueError, RuntimeError, OSError, MemoryError) as error:
        raise _unreadable(urdf, shape, " ".join(str(error).split()).rpartition("message: ")[2]) from error
    if not 0 < len(vertices) <= MOST_VERTICES:
        raise _unreadable(urdf, shape, f"{len(vertices)} vertices, of up to {MOST_VERTICES}")
    if not np.isfinite(vertices).all() or np.abs(vertices).max() > LARGEST_LENGTH:
        raise _unreadable(urdf, shape, f"a vertex that is not within {LARGEST_LENGTH:g} m of its origin")
    return vertices


def mesh_triangles(urdf: Path, shape: UrdfShape) -> NDArray[np.int64]:
    """Triangles of a mesh that `mesh_vertices` reads."""
    model = coal.MeshLoader().load(str(mesh_path(urdf, shape.file, shape.field)), np.array(shape.size))
    corners = (model.tri_indices(k) for k in range(model.num_tris))
    return np.array([[each[0], each[1], each[2]] for each in corners], dtype=np.int64).reshape(-1, 3)


def convex_hull(urdf: Path, shape: UrdfShape) -> Hull:
    """Convex hull of a mesh."""
    vertices = mesh_vertices(urdf, shape)
    extents = np.linalg.svd(vertices - vertices.mean(axis=0), compute_uv=False) / np.sqrt(len(vertices))
    if len(extents) < 3 or extents[0] < LOST or extents[2] < LOST * extents[0]:
        raise _unreadable(urdf, shape, "it has no volume")  # Qhull would end the process
    try:
        return _hull(vertices.tobytes())
    except (ValueError, RuntimeError) as error:
        raise _unreadable(urdf, shape, " ".join(str(error).split())) from error


def bounding_box(urdf: Path, shape: UrdfShape) -> tuple[Array, Array]:
    """Centre and lengths of the box along a shape's own axes that holds it, shapes (3,) [m]."""
    if shape.kind == "mesh":
        vertices = convex_hull(urdf, shape).vertices
        lowest, highest = vertices.min(axis=0), vertices.max(axis=0)
        return (lowest + highest) / 2, highest - lowest
    if shape.kind == "box":
        return np.zeros(3), np.array(shape.size)
    diameter = 2 * shape.size[0]
    return np.zeros(3), np.array([diameter, diameter, diameter if shape.kind == "sphere" else shape.size[1]])


@lru_cache(maxsize=64)
def _load(file: str, modified: int, scale: tuple[float, ...]) -> Array:  # noqa: ARG001  # a changed file is another one
    return frozen(coal.MeshLoader().load(file, np.array(scale)).vertices())


@lru_cache(maxsize=64)
def _hull(vertices: bytes) -> Hull:
    points = coal.StdVec_Vec3s()
    for vertex in np.frombuffer(vertices).reshape(-1, 3):
        points.append(vertex)
    hull = coal.Convex.convexHull(points, True, "Qt")
    triangles = np.array([[hull.polygons(k)[i] for i in range(3)] for k in range(hull.num_polygons)], dtype=np.int64)
    triangles.flags.writeable = False
    return Hull(frozen([hull.point(i) for i in range(hull.num_points)]), triangles)


def _unreadable(urdf: Path, shape: UrdfShape, why: str) -> UrdfError:
    return UrdfError(
        "a mesh cannot be read", file=urdf, field=shape.field, given=f"{shape.file}: {why}",
        allowed="a mesh with volume, in a format that assimp reads",
    )  # fmt: skip
