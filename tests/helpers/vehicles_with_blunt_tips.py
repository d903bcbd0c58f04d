"""The shipped vehicle with another shape at the end of its last link."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from urdf_variants import VEHICLE

TIP_AT = 0.25
"""From servo 4 to the tip's frame [m]."""


def write_with_end(path: Path, kind: str, size: Mapping[str, str], ahead: float, link: str = "servo_4") -> Path:
    """Write it with one more shape on a link.

    Args:
        path: Of the vehicle.
        kind: `box`, `cylinder`, `sphere`, or `mesh` of a box of the size that `box` would have.
        size: Attributes of the shape.
        ahead: Of its middle from the link's frame [m].
        link: That carries it.
    """
    tree = ElementTree.parse(VEHICLE)
    carrier = next(each for each in tree.getroot().findall("link") if each.get("name") == link)
    collision = ElementTree.SubElement(carrier, "collision", name="end")
    ElementTree.SubElement(collision, "origin", xyz=f"{ahead} 0 0")
    geometry = ElementTree.SubElement(collision, "geometry")
    if kind == "mesh":
        _write_box(path.with_suffix(".obj"), [float(word) for word in size["size"].split()])
        ElementTree.SubElement(geometry, "mesh", filename=path.with_suffix(".obj").name)
    else:
        ElementTree.SubElement(geometry, kind, dict(size))
    tree.write(path)
    return path


def _write_box(path: Path, size: list[float]) -> None:
    corners = [np.array([x, y, z]) * size / 2.0 for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in faces]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
