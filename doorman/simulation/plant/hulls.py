"""A URDF for MuJoCo: its meshes are the convex hulls that FCL and coal have, whatever format their files are in.

Shapes that count as a vehicle's tip are the tip's there, whichever link of the URDF carries them.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pinocchio

from doorman.arrays import Array
from doorman.exceptions import BackendError, UrdfError
from doorman.kinematics.urdf.elements import UrdfShape, read_collisions
from doorman.kinematics.urdf.mesh_hull import Hull, convex_hull
from doorman.kinematics.urdf.structure import check_structure


def read_spec(mujoco: Any, urdf: Path, tip: str = "", tip_shapes: Mapping[int, Array] | None = None) -> Any:
    """A URDF's links, joints and collision shapes as a specification."""
    root, hulls = check_structure(urdf), {}
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)  # the engine would look for their meshes
    _rename_world(root)
    for name, element, shape in _meshes(root, urdf):
        hulls[name] = _hull(urdf, shape)
        element.set("filename", f"{name}.stl")
        element.attrib.pop("scale", None)  # the hull has it
    _give_to_tip(root, urdf, tip, tip_shapes or {})
    try:
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    except ValueError as error:
        raise BackendError(f"MuJoCo cannot read the URDF: {' '.join(str(error).split())}", file=urdf) from error
    for mesh in spec.meshes:
        mesh.uservert, mesh.file = hulls[mesh.name].vertices.ravel(), ""
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    return spec


def mesh_of(urdf: Path, said: str, prefix: str) -> UrdfShape | None:
    """The mesh whose hull a message of MuJoCo names."""
    meshes = _meshes(check_structure(urdf), urdf)
    return next((shape for name, _, shape in meshes if f"'{prefix}{name}'" in said), None)


def _meshes(root: ElementTree.Element, urdf: Path) -> Iterator[tuple[str, ElementTree.Element, UrdfShape]]:
    """Name in the specification, element and shape of every mesh among the collision shapes."""
    elements = [element for link in root.findall("link") for element in link.iterfind("collision/geometry/*")]
    for index, (element, shape) in enumerate(zip(elements, read_collisions(urdf), strict=True)):
        if shape.kind == "mesh":
            yield f"hull_{index}", element, shape


def _give_to_tip(root: ElementTree.Element, urdf: Path, tip: str, shapes: Mapping[int, Array]) -> None:
    """Hang shapes of other links on the tip's, where they are."""
    links = {link.get("name"): link for link in root.findall("link")}
    elements = [(link, element) for link in links.values() for element in link.findall("collision")]
    for index, ((link, element), shape) in enumerate(zip(elements, read_collisions(urdf), strict=True)):
        if index not in shapes or shape.link == tip:
            continue
        placement = pinocchio.SE3(shapes[index] @ shape.placement)
        for origin in element.findall("origin"):
            element.remove(origin)
        angles = pinocchio.rpy.matrixToRpy(placement.rotation)
        xyz, rpy = (" ".join(map(repr, part.tolist())) for part in (placement.translation, angles))
        ElementTree.SubElement(element, "origin", xyz=xyz, rpy=rpy)
        element.set("name", element.get("name") or shape.name)
        link.remove(element)
        links[tip].append(element)


def _rename_world(root: ElementTree.Element) -> None:
    """Give a link `world` that hangs on another one a name of its own: the engine takes it for what all stands in."""
    ends = [end for joint in root.findall("joint") for end in (joint.find("parent"), joint.find("child"))]
    if any(end is not None and end.tag == "child" and end.get("link") == "world" for end in ends):
        links = {link.get("name"): link for link in root.findall("link")}
        name = next(name for k in range(len(links) + 1) if (name := f"world_{k}") not in links)
        links["world"].set("name", name)
        for end in ends:
            if end is not None and end.get("link") == "world":
                end.set("link", name)


def _hull(urdf: Path, shape: UrdfShape) -> Hull:
    try:
        return convex_hull(urdf, shape)
    except UrdfError as error:
        raise BackendError(
            f"MuJoCo cannot build it: {error.message}: {error.given}", file=urdf, field=f"link {shape.link}/collision/mesh",
            given=shape.file, allowed=error.allowed,
        ) from error  # fmt: skip
