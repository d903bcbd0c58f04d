"""Shapes of a URDF as written, and the tree of its links.

Read from the XML itself, in a millisecond: parsers of whole URDFs take more than a second to import.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.bounds import parse_numbers
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import read_joints
from doorman.kinematics.urdf.robot import frozen
from doorman.kinematics.urdf.structure import check_structure

_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}
"""Attributes that hold a primitive's size, by its kind."""


@dataclass(frozen=True)
class UrdfShape:
    """One shape, fixed to a link."""

    link: str
    name: str
    """Link and collision element, for example `frame/jamb_latch`; the link alone where it has one unnamed shape."""
    kind: str
    """`box`, `cylinder`, `sphere` or `mesh`."""
    size: tuple[float, ...]
    """Edges (x, y, z), (radius, length) of a cylinder about z, or (radius,) [m]; the scale along x, y and z of a mesh."""
    file: str
    """Name of the mesh; empty for the others."""
    placement: Array
    """Placement of the shape in the link, homogeneous, shape (4, 4)."""

    @property
    def field(self) -> str:
        """Place of the shape in the URDF, for an error."""
        return f"link {self.link}/collision {self.name}"


def read_collisions(path: Path) -> list[UrdfShape]:
    """All collision shapes of a URDF."""
    return _read(path, "collision")


def read_visuals(path: Path) -> list[UrdfShape]:
    """All visual shapes of a URDF."""
    return _read(path, "visual")


def read_parents(path: Path) -> dict[str, tuple[str, str]]:
    """Links that hang on a joint: its name, and the link above."""
    return {joint.child: (joint.name, joint.parent) for joint in read_joints(path).values()}


def link_name(path: Path, name: str) -> str:
    """The link of that name, or the child link of the joint of that name."""
    links = (link.get("name") for link in check_structure(path).findall("link"))
    return name if name in links else read_joints(path)[name].child


def _read(path: Path, tag: str) -> list[UrdfShape]:
    shapes = []
    for link in check_structure(path).findall("link"):
        elements, owner = link.findall(tag), link.get("name", "")
        for index, element in enumerate(elements):
            label = element.get("name") or (str(index) if len(elements) > 1 else "")
            shapes.append(_shape(path, owner, f"{owner}/{label}" if label else owner, element))
    return shapes


def _shape(path: Path, link: str, name: str, element: ElementTree.Element) -> UrdfShape:
    shape = element.find("geometry")[0]  # type: ignore[index]  # the structure's check has seen that there is one
    file = ""
    if shape.tag == "mesh":
        file, size = shape.get("filename", ""), parse_numbers(shape.get("scale", "1 1 1"))
    elif shape.tag in _SIZES:
        size = [number for attribute in _SIZES[shape.tag] for number in parse_numbers(shape.get(attribute, ""))]
    else:
        raise UrdfError(
            "not a valid URDF: no such shape", file=path, field=f"link {link}/collision {name}", given=shape.tag,
            allowed="box, cylinder, sphere or mesh",
        )  # fmt: skip
    return UrdfShape(link, name, shape.tag, tuple(size), file, _placement(element))


def _placement(element: ElementTree.Element) -> Array:
    origin = element.find("origin")
    if origin is None:
        return frozen(np.eye(4))
    rotation = pinocchio.rpy.rpyToMatrix(np.array(parse_numbers(origin.get("rpy", "0 0 0"))))
    position = np.array(parse_numbers(origin.get("xyz", "0 0 0")))
    return frozen(pinocchio.SE3(rotation, position).homogeneous)
