"""MuJoCo's messages as errors that name the URDF, and the link or mesh at fault."""

from __future__ import annotations

from pathlib import Path

from doorman.exceptions import BackendError
from doorman.kinematics.urdf.structure import check_structure
from doorman.model import Model
from doorman.simulation.plant.assembly import DOOR, VEHICLE
from doorman.simulation.plant.hulls import mesh_of


def build_fault(model: Model, error: ValueError) -> BackendError:
    """Error of a plant that MuJoCo does not build."""
    said = " ".join(str(error).split())
    message = f"MuJoCo cannot build it: {said}"
    parts = ((model.true_door.urdf, DOOR), (model.vehicle.urdf, VEHICLE))
    for urdf, prefix in parts:
        mesh = mesh_of(urdf, said, prefix)
        if mesh is not None:
            return BackendError(
                message, file=urdf, field=f"link {mesh.link}/collision/mesh", given=mesh.file,
                allowed="a mesh with volume; or boxes, cylinders and spheres",
            )  # fmt: skip
    for urdf, prefix in parts:
        link_name = _link(urdf, prefix, said)
        if link_name is not None:
            return BackendError(message, file=urdf, field=f"link {link_name}", allowed="a link that MuJoCo can build")
    return BackendError(
        message, file=model.vehicle.urdf, given=str(model.true_door.urdf),
        allowed="collision shapes as boxes, cylinders and spheres",
    )  # fmt: skip


def _link(urdf: Path, prefix: str, said: str) -> str | None:
    """Link that a message names, by itself or by one of its shapes."""
    for link in check_structure(urdf).findall("link"):
        name, shapes = link.get("name", ""), link.findall("collision")
        names = [name, *(shape.get("name") or f"{name}_{index}" for index, shape in enumerate(shapes))]
        if any(f"'{prefix}{one}'" in said for one in names):
            return name
    return None
