"""Meshcat's commands as plain data: shapes, placements and properties for the viewer in the page."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.visualization.scene.shapes import VisualShape

Command = dict[str, Any]

_Y_TO_Z = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def show(path: str, shape: VisualShape) -> list[Command]:
    turn = _Y_TO_Z if shape.kind == "cylinder" else np.eye(4)  # the viewer's cylinders stand along y
    return [_set_object(path, _geometry(shape), shape.color), place(path, shape.placement @ turn)]


def place(path: str, placement: Array) -> Command:
    return {"type": "set_transform", "path": path, "matrix": placement.T.ravel().round(6).tolist()}


def set_property(path: str, name: str, value: Any) -> Command:
    """The command that sets a property of a node."""
    return {"type": "set_property", "path": path, "property": name, "value": value}


def _geometry(shape: VisualShape) -> Command:
    if shape.kind == "box":
        return {"type": "BoxGeometry", **dict(zip(("width", "height", "depth"), shape.size, strict=True))}
    if shape.kind == "sphere":
        return {"type": "SphereGeometry", "radius": shape.size[0], "widthSegments": 20, "heightSegments": 20}
    radius, length = shape.size
    return {
        "type": "CylinderGeometry",
        "radiusTop": radius,
        "radiusBottom": radius,
        "height": length,
        "radialSegments": 40,
    }


def _set_object(path: str, geometry: Command, color: tuple[float, float, float, float]) -> Command:
    red, green, blue = (round(255 * value) for value in color[:3])
    material = {
        "uuid": f"{path}#material",
        "type": "MeshPhongMaterial",
        "color": red << 16 | green << 8 | blue,
        "opacity": color[3],
        "transparent": color[3] < 1.0,
        "depthWrite": color[3] == 1.0,  # what lies behind a translucent shape shows through it
    }
    mesh = {"uuid": path, "type": "Mesh", "geometry": f"{path}#geometry", "material": f"{path}#material"}
    content = {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": f"{path}#geometry", **geometry}],
        "materials": [material],
        "object": mesh,
    }
    return {"type": "set_object", "path": path, "object": content}
