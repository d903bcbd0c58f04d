"""Collision shapes of a URDF as FCL geometry: boxes, cylinders, spheres, and the convex hulls of meshes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import coal
import fcl
import numpy as np
import yourdfpy
from numpy.typing import NDArray

from doorman.exceptions import UrdfError
from doorman.kinematics.meshes import mesh_path
from doorman.kinematics.urdf import frozen, load_description

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """One collision shape, fixed to a link."""

    name: str
    """Link and collision element, for example `frame/jamb_latch`; the link alone where it has one unnamed shape."""
    link: str
    placement: Array
    """Of the centre of the shape's bounding box in the link, homogeneous, shape (4, 4)."""
    half_extents: Array
    """Of the bounding box about its centre, shape (3,) [m]."""
    geometry: Any
    """FCL geometry, its origin at the centre of the bounding box."""

    @property
    def radius(self) -> float:
        """Radius of the sphere about the centre of the bounding box that holds the shape [m]."""
        return float(np.linalg.norm(self.half_extents))


def read_shapes(path: Path) -> list[Shape]:
    """All collision shapes of a URDF.

    Args:
        path: URDF file.

    Returns:
        The shapes, in the order of the file.

    Raises:
        UrdfError: if a mesh is missing or cannot be read.
    """
    shapes = []
    for name, link in load_description(path).link_map.items():
        for index, collision in enumerate(link.collisions):
            label = collision.name or (str(index) if len(link.collisions) > 1 else "")
            full_name = f"{name}/{label}" if label else name
            shapes.append(_shape(path, name, full_name, collision))
    return shapes


def _shape(path: Path, link: str, name: str, collision: yourdfpy.Collision) -> Shape:
    geometry, field = collision.geometry, f"link {link}/collision {name}"
    placement = np.eye(4) if collision.origin is None else np.array(collision.origin, dtype=np.float64)
    make: Callable[[], Any]
    if geometry.box is not None:
        half = np.asarray(geometry.box.size, dtype=np.float64) / 2
        make = partial(fcl.Box, *(2 * half))
    elif geometry.cylinder is not None:
        radius, length = float(geometry.cylinder.radius), float(geometry.cylinder.length)
        half = np.array([radius, radius, length / 2])
        make = partial(fcl.Cylinder, radius, length)
    elif geometry.sphere is not None:
        half = np.full(3, float(geometry.sphere.radius))
        make = partial(fcl.Sphere, float(half[0]))
    else:  # the reader lets nothing else through
        vertices, faces = _convex_hull(path, field, geometry.mesh)
        center = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        half = (vertices.max(axis=0) - vertices.min(axis=0)) / 2
        placement[:3, 3] += placement[:3, :3] @ center
        make = partial(fcl.Convex, vertices - center, len(faces) // 4, faces)
    return Shape(name, link, frozen(placement), frozen(half), make())


def _convex_hull(path: Path, field: str, mesh: yourdfpy.Mesh) -> tuple[Array, NDArray[np.int64]]:
    """Vertices (m, 3) of a mesh's convex hull, and its triangles in FCL's flat form: 3 and three indices each."""
    file = mesh_path(path, mesh.filename, field)
    if not file.is_file():
        raise UrdfError("no such mesh", file=path, field=field, given=mesh.filename, allowed="an existing file")
    scale = np.ones(3) if mesh.scale is None else np.broadcast_to(np.asarray(mesh.scale, dtype=np.float64), 3).copy()
    points = coal.StdVec_Vec3s()
    try:
        for vertex in np.asarray(coal.MeshLoader().load(str(file), scale).vertices()):
            points.append(vertex)
        hull = coal.Convex.convexHull(points, True, "Qt")
    except (ValueError, RuntimeError) as error:
        raise UrdfError(
            "a mesh cannot be read", file=path, field=field, given=f"{mesh.filename}: {error}",
            allowed="a mesh with volume, in a format that assimp reads",
        ) from error  # fmt: skip
    vertices = np.array([hull.point(i) for i in range(hull.num_points)])
    triangles = [hull.polygons(i) for i in range(hull.num_polygons)]
    return vertices, np.array([[3, t[0], t[1], t[2]] for t in triangles], dtype=np.int64).ravel()
