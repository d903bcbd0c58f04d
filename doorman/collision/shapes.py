"""Collision shapes of a URDF as FCL geometry: boxes, cylinders, spheres, hulls of meshes; and which of a vehicle's are its tip.

The tip touches the leaf by design. A last link whose hull holds the tip's frame, or ends beside it, touches with that hull.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fcl
import numpy as np

from doorman.arrays import Array, frozen
from doorman.collision.surroundings import ROUNDED
from doorman.kinematics.doors.door import Door
from doorman.kinematics.urdf.elements import UrdfShape, link_name, read_collisions, read_parents
from doorman.kinematics.urdf.mesh_hull import bounding_box, convex_hull
from doorman.kinematics.vehicles.vehicle import Vehicle


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


_PRIMITIVES: dict[str, Callable[..., Any]] = {"box": fcl.Box, "cylinder": fcl.Cylinder, "sphere": fcl.Sphere}
"""What makes a primitive's geometry of its size."""


def read_shapes(path: Path) -> list[Shape]:
    """All collision shapes of a URDF."""
    return [_shape(path, written) for written in read_collisions(path)]


def _shape(path: Path, written: UrdfShape) -> Shape:
    placement, (center, size) = np.array(written.placement), bounding_box(path, written)
    placement[:3, 3] += placement[:3, :3] @ center
    if written.kind == "mesh":
        hull = convex_hull(path, written)
        faces = np.insert(hull.triangles, 0, 3, axis=1).ravel()  # FCL's form: 3, then three indices each
        geometry = fcl.Convex(hull.vertices - center, len(hull.triangles), faces)
    else:
        geometry = _PRIMITIVES[written.kind](*written.size)
    return Shape(written.name, written.link, frozen(placement), frozen(size / 2), geometry)


def tip_link(vehicle: Vehicle) -> str:
    """Name of the tip's link; a scenario may also name the tip by the joint that carries it."""
    return link_name(vehicle.urdf, vehicle.names.tip)


def arm_joint_of_links(vehicle: Vehicle) -> dict[str, int]:
    """For every link how many of the arm's joints move it: 0 is fixed to the base link."""
    parents = read_parents(vehicle.urdf)
    counts = {}
    for link in vehicle.link_placements(np.zeros(vehicle.n_arm)):
        count, at = 0, link
        while at in parents:
            joint, at = parents[at]
            count += joint in vehicle.joint_names
        counts[link] = count
    return counts


def tip_shapes(vehicle: Vehicle) -> dict[int, Array]:
    """Shapes that may touch the leaf: those of the tip's link, and those fixed to it at whose hull the tip is."""
    placements, tip = vehicle.link_placements(np.zeros(vehicle.n_arm)), tip_link(vehicle)
    moved, found = arm_joint_of_links(vehicle), {}
    for index, shape in enumerate(read_shapes(vehicle.urdf)):
        if moved[shape.link] != vehicle.n_arm:
            continue
        link_in_tip = np.asarray(np.linalg.solve(placements[tip], placements[shape.link]), dtype=np.float64)
        if shape.link == tip or _is_at(
            shape, np.asarray(np.linalg.inv(link_in_tip @ shape.placement)[:3, 3], dtype=np.float64)
        ):
            found[index] = link_in_tip
    return found


def tip_and_frame(vehicle: Vehicle, door: Door) -> list[tuple[str, str]]:
    """Pairs of links, the tip's first, that touch where the tip is to touch what stands beside the leaf."""
    shapes, others = read_shapes(vehicle.urdf), {shape.link for shape in read_shapes(door.urdf)}
    tips = {shapes[index].link for index in tip_shapes(vehicle)}
    return sorted((tip, other) for tip in tips for other in others - {door.section.leaf})


def _is_at(shape: Shape, point: Array) -> bool:
    """Whether a point is at the shape's hull: shape (3,), from the centre of its bounding box [m]."""
    ball = fcl.CollisionObject(fcl.Sphere(ROUNDED), fcl.Transform(point))
    request = fcl.DistanceRequest(enable_signed_distance=True)
    distance = fcl.distance(ball, fcl.CollisionObject(shape.geometry), request, fcl.DistanceResult())
    return bool(distance <= shape.half_extents.min())
