"""What a URDF says as written: its joints, its shapes and the tree of its links.

Read from the XML itself, in a millisecond: parsers of whole URDFs take half a second and more to import, and Pinocchio keeps no
shapes, leaders of joints, nor the names of what carries them.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array, frozen
from doorman.bounds import parse_numbers
from doorman.kinematics.urdf.structure import check_structure

_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "mesh": ("scale",)}
"""Attributes that hold a shape's size, by its kind."""


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as written, of any type."""

    name: str
    kind: str
    """`revolute`, `prismatic`, `fixed` and so on."""
    child: str
    """Link that it carries."""
    parent: str
    """Link that it hangs on."""
    axis: tuple[float, float, float]
    """In the child's frame at rest."""
    effort: float
    """`<limit effort>`, 0 without limits [N m] or [N]."""
    limited: bool
    """Whether `<limit>` is written."""
    damping: float
    """`<dynamics damping>`, 0 by default [N m s/rad]."""
    friction: float
    """`<dynamics friction>`, 0 by default [N m]."""
    leader: str | None
    """Joint that it follows by `<mimic>`."""


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


def read_joints(path: Path) -> dict[str, UrdfJoint]:
    """Joints of a URDF by name, in the order of the file."""
    return {joint.name: joint for joint in map(_joint, check_structure(path).findall("joint"))}


def read_parents(path: Path) -> dict[str, tuple[str, str]]:
    """Links that hang on a joint: its name, and the link above."""
    return {joint.child: (joint.name, joint.parent) for joint in read_joints(path).values()}


def link_name(path: Path, name: str) -> str:
    """The link of that name, or the child link of the joint of that name."""
    links = (link.get("name") for link in check_structure(path).findall("link"))
    return name if name in links else read_joints(path)[name].child


def read_collisions(path: Path, tag: str = "collision") -> list[UrdfShape]:
    """All collision shapes of a URDF."""
    shapes = []
    for link in check_structure(path).findall("link"):
        elements, owner = link.findall(tag), link.get("name", "")
        for index, element in enumerate(elements):
            label = element.get("name") or (str(index) if len(elements) > 1 else "")
            shapes.append(_shape(owner, f"{owner}/{label}" if label else owner, element))
    return shapes


def read_visuals(path: Path) -> list[UrdfShape]:
    """All visual shapes of a URDF."""
    return read_collisions(path, "visual")


def _joint(element: ElementTree.Element) -> UrdfJoint:
    mimic = element.find("mimic")
    x, y, z = _numbers(element, "axis", "xyz", "1 0 0")
    return UrdfJoint(
        name=element.get("name", ""),
        kind=element.get("type", ""),
        child=_text(element, "child", "link", ""),
        parent=_text(element, "parent", "link", ""),
        axis=(x, y, z),
        effort=_numbers(element, "limit", "effort", "0")[0],
        limited=element.find("limit") is not None,
        damping=_numbers(element, "dynamics", "damping", "0")[0],
        friction=_numbers(element, "dynamics", "friction", "0")[0],
        leader=None if mimic is None else mimic.get("joint", ""),
    )


def _shape(link: str, name: str, element: ElementTree.Element) -> UrdfShape:
    shape = element.find("geometry")[0]  # type: ignore[index]  # the structure's check has seen that there is one
    size = [number for attribute in _SIZES[shape.tag] for number in parse_numbers(shape.get(attribute, "1 1 1"))]
    return UrdfShape(link, name, shape.tag, tuple(size), shape.get("filename", ""), frozen(placement_of(element)))


def placement_of(element: ElementTree.Element) -> Array:
    """Placement of a shape or an inertial in its link, homogeneous, shape (4, 4)."""
    xyz, rpy = (np.array(_numbers(element, "origin", attribute, "0 0 0")) for attribute in ("xyz", "rpy"))
    return np.array(pinocchio.SE3(pinocchio.rpy.rpyToMatrix(rpy), xyz).homogeneous)


def _numbers(element: ElementTree.Element, tag: str, attribute: str, default: str) -> list[float]:
    """Numbers of a child's attribute; the structure's check has seen that they are there and finite."""
    return parse_numbers(_text(element, tag, attribute, default))


def _text(element: ElementTree.Element, tag: str, attribute: str, default: str) -> str:
    child = element.find(tag)
    return default if child is None else child.get(attribute, default)
