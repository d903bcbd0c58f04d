"""Visual shapes of a URDF: boxes, cylinders and spheres with their colours; rods along the joints where it has only meshes."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias, cast

import numpy as np

from doorman.arrays import Array, frozen
from doorman.bounds import parse_numbers
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfShape, read_visuals
from doorman.kinematics.urdf.structure import check_structure

Kind: TypeAlias = Literal["box", "cylinder", "sphere"]
Color: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue, opacity; each 0 to 1."""


@dataclass(frozen=True)
class VisualShape:
    """One primitive shape, fixed to a link."""

    link: str
    kind: Kind
    size: tuple[float, ...]  # edges (x, y, z), or (radius, length) of a cylinder about z, or (radius,) [m]
    placement: Array  # of the shape's centre in the link, homogeneous, shape (4, 4)
    color: Color = (0.6, 0.6, 0.6, 1.0)  # of its surface; grey where nothing else is said


def visual_shapes(path: Path) -> tuple[VisualShape, ...]:
    # Meshes are not read: a link that has nothing but meshes is drawn as rods from its origin to the joints it carries.
    root = check_structure(path)
    written = list(zip(read_visuals(path), root.findall("link/visual"), strict=True))
    named = {
        str(material.get("name")): color for material in root.findall("material") if (color := _color(path, material))
    }
    shapes: list[VisualShape] = []
    for link in (str(link.get("name")) for link in root.findall("link")):
        own = [(shape, visual) for shape, visual in written if shape.link == link]
        primitives = [_primitive(path, shape, visual, named) for shape, visual in own if shape.kind != "mesh"]
        carried = [joint.find("origin") for joint in root.findall("joint") if joint.find("parent").get("link") == link]  # type: ignore[union-attr]
        ends = [np.array(parse_numbers(one.get("xyz", "0 0 0"))) for one in carried if one is not None]
        shapes += primitives if primitives or not own else _rods(link, ends)
    return tuple(shapes)


def _primitive(path: Path, shape: UrdfShape, visual: ElementTree.Element, named: Mapping[str, Color]) -> VisualShape:
    material = visual.find("material")
    color = None if material is None else _color(path, material) or named.get(material.get("name", ""))
    kind = cast(Kind, shape.kind)  # a mesh is none of ours
    drawn = VisualShape(shape.link, kind, shape.size, shape.placement)
    return drawn if color is None else replace(drawn, color=color)


def _color(path: Path, material: ElementTree.Element) -> Color | None:
    """Colour of a material; None if it only names one."""
    color = material.find("color")
    if color is None:
        return None
    text = color.get("rgba", "")
    try:
        red, green, blue, opacity = parse_numbers(text)
    except ValueError as error:
        raise UrdfError(
            "not a colour", file=path, field=f"material {material.get('name')}/color@rgba", given=text,
            allowed="four numbers from 0 to 1",
        ) from error  # fmt: skip
    return red, green, blue, opacity


def _rods(link: str, ends: Sequence[Array], radius: float = 0.008) -> list[VisualShape]:
    rods = []
    for end in ends:
        length = float(np.linalg.norm(end))
        if length > 1e-6:
            placement = np.eye(4)
            placement[:3, :3] = _turn_z_towards(end / length)
            placement[:3, 3] = end / 2
            rods.append(VisualShape(link, "cylinder", (radius, length), frozen(placement)))
    return rods


def _turn_z_towards(direction: Array) -> Array:
    """A rotation, shape (3, 3), whose z axis is `direction`."""
    across = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    across /= np.linalg.norm(across)
    return np.column_stack([across, np.cross(direction, across), direction])
