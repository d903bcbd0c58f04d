"""A URDF for MuJoCo: its meshes are the convex hulls that FCL and coal have, whatever format their files are in."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from doorman.exceptions import BackendError, UrdfError
from doorman.kinematics.urdf.mesh_hull import Hull, convex_hull
from doorman.kinematics.urdf.shapes import UrdfShape, read_collisions
from doorman.kinematics.urdf.structure import check_structure


def read_spec(mujoco: Any, urdf: Path) -> Any:
    """A URDF's links, joints and collision shapes as a specification.

    Args:
        mujoco: The engine.
        urdf: The file.

    Returns:
        MjSpec.

    Raises:
        BackendError: if MuJoCo cannot read the URDF, or a mesh cannot be read; names the mesh.
    """
    root, hulls = check_structure(urdf), {}
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)  # the engine would look for their meshes
    for name, element, shape in _meshes(root, urdf):
        hulls[name] = _hull(urdf, shape)
        element.set("filename", f"{name}.stl")
        element.attrib.pop("scale", None)  # the hull has it
    try:
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    except ValueError as error:
        raise BackendError(f"MuJoCo cannot read the URDF: {' '.join(str(error).split())}", file=urdf) from error
    for mesh in spec.meshes:
        mesh.uservert, mesh.file = hulls[mesh.name].vertices.ravel(), ""
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    return spec


def mesh_of(urdf: Path, said: str, prefix: str) -> UrdfShape | None:
    """The mesh whose hull a message of MuJoCo names.

    Args:
        urdf: The file.
        said: The message.
        prefix: Of the names in the specification.

    Returns:
        Its shape as written; None if there is none.
    """
    meshes = _meshes(check_structure(urdf), urdf)
    return next((shape for name, _, shape in meshes if f"'{prefix}{name}'" in said), None)


def _meshes(root: ElementTree.Element, urdf: Path) -> Iterator[tuple[str, ElementTree.Element, UrdfShape]]:
    """Name in the specification, element and shape of every mesh among the collision shapes."""
    elements = [element for link in root.findall("link") for element in link.iterfind("collision/geometry/*")]
    for index, (element, shape) in enumerate(zip(elements, read_collisions(urdf), strict=True)):
        if shape.kind == "mesh":
            yield f"hull_{index}", element, shape


def _hull(urdf: Path, shape: UrdfShape) -> Hull:
    try:
        return convex_hull(urdf, shape)
    except UrdfError as error:
        raise BackendError(
            f"MuJoCo cannot build it: {error.message}: {error.given}", file=urdf, field=f"link {shape.link}/collision/mesh",
            given=shape.file, allowed=error.allowed,
        ) from error  # fmt: skip
