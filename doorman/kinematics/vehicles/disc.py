r"""Radius R_A of the disc that holds the rotors, from a vehicle's URDF.

The collision shapes fixed to the base link tell it where they reach every rotor's axis. Where they do not, as those of a hub
alone, it is that of the rotors: :math:`R_A = \max_i (|r_i| + \rho_i)` with the propeller's radius ρ, from the shapes of the
rotor's link. A rotor without shapes has a propeller that reaches half the way to the next rotor.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfShape, read_collisions, read_visuals
from doorman.kinematics.urdf.mesh_files import mesh_path
from doorman.kinematics.urdf.mesh_hull import mesh_vertices
from doorman.kinematics.urdf.robot import link_index
from doorman.kinematics.vehicles.rotors import rotor_links


def disc_radius(urdf: Path, model: pinocchio.Model) -> float:
    """Radius of the disc about the body's z axis that holds the body and its rotors."""
    shapes = [shape for shape in read_collisions(urdf) if _frame(urdf, model, shape.link).parentJoint == 0]
    for shape in shapes:
        if shape.kind == "mesh":
            mesh_path(urdf, shape.file, shape.field)  # an address of another kind has an error of its own
    try:
        placed = (
            (shape, _frame(urdf, model, shape.link).placement * pinocchio.SE3(shape.placement)) for shape in shapes
        )
        body = max((_reach(urdf, shape, placement) for shape, placement in placed), default=0.0)
    except UrdfError as error:
        raise UrdfError(
            "collision meshes cannot be read; set vehicle.radius", file=urdf, field="vehicle.radius",
            given=f"{error.field}: {error.message}: {error.given}", allowed="meshes that exist, or a radius > 0 m",
        ) from error  # fmt: skip
    hubs, radii = _propellers(urdf, model)
    away = np.hypot(*hubs.T[:2])
    if body < away.max(initial=0.0):
        return max(body, float((away + np.where(radii > 0.0, radii, _half_way_to_the_next(hubs))).max()))
    if not body > 0.0:
        raise UrdfError(
            "the URDF has no collision shape and no rotor to take the radius from; set vehicle.radius",
            file=urdf, field="vehicle.radius", given="none", allowed="> 0 m",
        )  # fmt: skip
    return body


def propeller_reach(urdf: Path, model: pinocchio.Model) -> float:
    """Largest distance of a propeller's tip from the body's z axis, of the rotors whose links have shapes."""
    hubs, radii = _propellers(urdf, model)
    return float((np.hypot(*hubs.T[:2]) + radii)[radii > 0.0].max(initial=0.0))


def _propellers(urdf: Path, model: pinocchio.Model) -> tuple[Array, Array]:
    """Origins of the rotors' frames in the body, shape (m, 3), and radii, (m,), zero without a shape that can be read [m]."""
    radii = dict.fromkeys(rotor_links(urdf), 0.0)
    for shape in (*read_collisions(urdf), *read_visuals(urdf)):
        if shape.link in radii:
            try:
                reach = _reach(urdf, shape, pinocchio.SE3(shape.placement))
            except UrdfError:
                continue  # a visual's mesh may be missing
            radii[shape.link] = max(radii[shape.link], reach)
    hubs = [_frame(urdf, model, link).placement.translation for link in radii]
    return np.array(hubs).reshape(-1, 3), np.array([*radii.values()])


def _half_way_to_the_next(hubs: Array) -> Array:
    """Half the distance of every hub from the nearest other one, shape (m,); zero of a single one [m]."""
    apart = np.linalg.norm(hubs[:, None] - hubs, axis=2)
    np.fill_diagonal(apart, np.inf)
    between = 0.5 * apart.min(axis=1)
    return np.where(np.isfinite(between), between, 0.0)


def _frame(urdf: Path, model: pinocchio.Model, link: str) -> pinocchio.Frame:
    return model.frames[link_index(model, link, urdf, f"link {link}")]


def _reach(urdf: Path, shape: UrdfShape, placement: pinocchio.SE3) -> float:
    """Largest distance of a shape's points from the z axis; exact for upright cylinders, spheres, boxes and meshes."""
    rotation, origin = placement.rotation, placement.translation
    if shape.kind == "sphere":
        return float(np.hypot(*origin[:2]) + shape.size[0])
    if shape.kind == "cylinder":
        radius, length = shape.size
        return float(np.hypot(*origin[:2]) + radius + np.hypot(*rotation[:2, 2]) * 0.5 * length)
    if shape.kind == "box":
        corners = 0.5 * np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T * shape.size
    else:
        corners = mesh_vertices(urdf, shape)
    points = origin + corners @ rotation.T
    return float(np.hypot(points[:, 0], points[:, 1]).max())
