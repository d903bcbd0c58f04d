"""Visual shapes of a URDF: boxes, cylinders and spheres with their colours; rods along the joints where it has only meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import yourdfpy
from numpy.typing import NDArray

from doorman.kinematics.urdf import frozen, load_description

Array = NDArray[np.float64]

_GREY = (0.6, 0.6, 0.6, 1.0)
_ROD_RADIUS = 0.008


@dataclass(frozen=True)
class VisualShape:
    """One primitive shape, fixed to a link."""

    link: str
    kind: Literal["box", "cylinder", "sphere"]
    size: tuple[float, ...]
    """Edges (x, y, z), or (radius, length) of a cylinder about z, or (radius,) [m]."""
    placement: Array
    """Of the shape's centre in the link, homogeneous, shape (4, 4)."""
    color: tuple[float, float, float, float]
    """Red, green, blue, opacity; each 0 to 1."""


def visual_shapes(path: Path) -> tuple[VisualShape, ...]:
    """What a URDF looks like.

    Meshes are not read: a link that has nothing but meshes is drawn as rods from its origin to the joints it carries.

    Args:
        path: URDF file.

    Returns:
        The shapes, in the order of the links.

    Raises:
        UrdfError: if the URDF cannot be read.
    """
    robot = load_description(path)
    colors = {material.name: material.color for material in robot.robot.materials}
    shapes: list[VisualShape] = []
    for name, link in robot.link_map.items():
        primitives = [shape for visual in link.visuals if (shape := _primitive(name, visual, colors)) is not None]
        if link.visuals and not primitives:
            joints = [joint for joint in robot.robot.joints if joint.parent == name and joint.origin is not None]
            primitives = _rods(name, [np.asarray(joint.origin)[:3, 3] for joint in joints])
        shapes.extend(primitives)
    return tuple(shapes)


def _primitive(link: str, visual: yourdfpy.Visual, colors: dict[str, yourdfpy.Color | None]) -> VisualShape | None:
    geometry = visual.geometry
    placement = frozen(np.eye(4) if visual.origin is None else visual.origin)
    material = visual.material
    color = None if material is None else material.color or colors.get(material.name)
    red, green, blue, opacity = _GREY if color is None else (float(value) for value in color.rgba)
    rgba = (red, green, blue, opacity)
    if geometry is None:
        return None
    if geometry.box is not None:
        return VisualShape(link, "box", tuple(float(edge) for edge in geometry.box.size), placement, rgba)
    if geometry.cylinder is not None:
        size = (float(geometry.cylinder.radius), float(geometry.cylinder.length))
        return VisualShape(link, "cylinder", size, placement, rgba)
    if geometry.sphere is not None:
        return VisualShape(link, "sphere", (float(geometry.sphere.radius),), placement, rgba)
    return None


def _rods(link: str, ends: Sequence[Array]) -> list[VisualShape]:
    rods = []
    for end in ends:
        length = float(np.linalg.norm(end))
        if length > 1e-6:
            placement = np.eye(4)
            placement[:3, :3] = _turn_z_towards(end / length)
            placement[:3, 3] = end / 2
            rods.append(VisualShape(link, "cylinder", (_ROD_RADIUS, length), frozen(placement), _GREY))
    return rods


def _turn_z_towards(direction: Array) -> Array:
    """A rotation, shape (3, 3), whose z axis is `direction`."""
    across = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    across /= np.linalg.norm(across)
    return np.column_stack([across, np.cross(direction, across), direction])
