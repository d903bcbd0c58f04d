"""Collision shapes of a URDF as FCL geometry: boxes, cylinders, spheres, and the convex hulls of meshes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import fcl
import numpy as np

from doorman.arrays import Array
from doorman.kinematics.urdf.mesh_hull import convex_hull
from doorman.kinematics.urdf.robot import frozen
from doorman.kinematics.urdf.shapes import UrdfShape, read_collisions


@dataclass(frozen=True)
class Shape:
    """One collision shape, fixed to a link."""

    name: str
    """Link and collision element, for example `frame/jamb_latch`; the link alone where it has one unnamed shape."""
    link: str
    placement: Array
    """Centre and axes of the shape's bounding box in the link, homogeneous, shape (4, 4)."""
    half_extents: Array
    """Half the lengths of the bounding box, shape (3,) [m]."""
    geometry: Any
    """FCL geometry, its origin at the centre of the bounding box."""

    @property
    def radius(self) -> float:
        """Radius of the sphere about the centre of the bounding box that holds the shape [m]."""
        return float(np.linalg.norm(self.half_extents))


def read_shapes(path: Path) -> list[Shape]:
    """All collision shapes of a URDF."""
    return [_shape(path, written) for written in read_collisions(path)]


def _shape(path: Path, written: UrdfShape) -> Shape:
    placement, make = np.array(written.placement), _maker(written)
    if make is not None:
        half = _half_extents(written)
    else:
        hull = convex_hull(path, written)
        vertices = hull.vertices
        faces = np.insert(hull.triangles, 0, 3, axis=1).ravel()  # FCL's form: 3, then three indices each
        center = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        half = (vertices.max(axis=0) - vertices.min(axis=0)) / 2
        placement[:3, 3] += placement[:3, :3] @ center
        make = partial(fcl.Convex, vertices - center, len(hull.triangles), faces)
    return Shape(written.name, written.link, frozen(placement), frozen(half), make())


def _maker(written: UrdfShape) -> Callable[[], Any] | None:
    """What makes the FCL geometry of a primitive; None for a mesh."""
    primitives = {"box": fcl.Box, "cylinder": fcl.Cylinder, "sphere": fcl.Sphere}
    return partial(primitives[written.kind], *written.size) if written.kind in primitives else None


def _half_extents(written: UrdfShape) -> Array:
    """Half the lengths of a primitive's box, shape (3,) [m]."""
    if written.kind == "box":
        return np.array(written.size) / 2
    if written.kind == "cylinder":
        radius, length = written.size
        return np.array([radius, radius, length / 2])
    return np.full(3, written.size[0])
