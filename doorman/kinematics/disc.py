"""Radius R_A of the disc that holds the rotors, from the collision shapes of a vehicle's URDF."""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np
import pinocchio

from doorman.exceptions import UrdfError
from doorman.kinematics.mesh_checks import unreadable_mesh
from doorman.kinematics.meshes import with_mesh_paths
from doorman.kinematics.urdf import load_pinocchio
from doorman.kinematics.urdf_structure import check_structure


def disc_radius(urdf: Path, base: pinocchio.SE3) -> float:
    """Radius of the disc about the body's z axis that holds every collision shape fixed to the base link.

    Args:
        urdf: Path of the URDF.
        base: Placement of the base link in the root frame.

    Returns:
        R_A [m].

    Raises:
        UrdfError: if the base link has no collision shape, or a mesh cannot be read.
    """
    try:
        geometry = pinocchio.buildGeomFromUrdfString(
            load_pinocchio(urdf), with_mesh_paths(urdf), pinocchio.GeometryType.COLLISION
        )
    except (ValueError, RuntimeError) as error:
        given = unreadable_mesh(urdf, check_structure(urdf)) or " ".join(str(error).split())
        raise UrdfError(
            "collision meshes cannot be read; set vehicle.radius", file=urdf, field="vehicle.radius",
            given=given, allowed="meshes that exist, or a radius > 0 m",
        ) from error  # fmt: skip
    reaches = [
        _horizontal_reach(item.geometry, base.inverse() * item.placement)
        for item in geometry.geometryObjects
        if item.parentJoint == 0
    ]
    if not reaches:
        raise UrdfError(
            "the base link has no collision shape to take the radius from; set vehicle.radius",
            file=urdf,
            field="vehicle.radius",
            given="none",
            allowed="> 0 m",
        )
    return max(reaches)


def _horizontal_reach(shape: coal.CollisionGeometry, placement: pinocchio.SE3) -> float:
    """Largest distance of a shape's points from the z axis; exact for upright cylinders, spheres and boxes."""
    rotation, origin = placement.rotation, placement.translation
    if isinstance(shape, coal.Sphere):
        return float(np.hypot(*origin[:2]) + shape.radius)
    if isinstance(shape, coal.Cylinder):
        tilt = float(np.hypot(rotation[0, 2], rotation[1, 2]))
        center = float(np.hypot(*origin[:2]))
        return float(center + shape.radius + tilt * shape.halfLength)
    if isinstance(shape, coal.Box):
        signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
        corners = origin + (signs * shape.halfSide) @ rotation.T
    else:
        corners = origin + np.asarray(shape.vertices()) @ rotation.T
    return float(np.hypot(corners[:, 0], corners[:, 1]).max())
