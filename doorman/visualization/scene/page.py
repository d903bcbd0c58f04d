"""The page that shows a flight in three dimensions: meshcat's viewer, this folder's script, and the drawing, in one file.

The page needs neither network nor meshcat's server: the viewer's script stands in it, and what the server would send is data.
"""

from __future__ import annotations

import html
import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import DoormanError, how_to_install
from doorman.visualization.scene.shapes import VisualShape

Command = dict[str, Any]

Y_TO_Z = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
"""Turns what stands along y, as the viewer has it up, to stand along z."""


def show(path: str, shape: VisualShape) -> list[Command]:
    turn = Y_TO_Z if shape.kind == "cylinder" else np.eye(4)  # the viewer's cylinders stand along y
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
    ends = {"radiusTop": radius, "radiusBottom": radius}
    return {"type": "CylinderGeometry", **ends, "height": length, "radialSegments": 40}


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


def page(title: str, scene: Command, frames: Sequence[dict[str, Any]], live: str = "") -> str:
    folder = Path(__file__).parent
    template = Template((folder / "view.html").read_text(encoding="utf-8"))
    data = {"scene": scene, "frames": list(frames), "live": live}
    return template.substitute(
        title=html.escape(title),
        viewer=_viewer_source(),
        flight=_in_script(json.dumps(data, allow_nan=False, separators=(",", ":"))),
        script=(folder / "view.js").read_text(encoding="utf-8"),
    )


def _in_script(data: str) -> str:
    """JSON that neither ends the script element that it stands in, nor opens another."""
    return data.replace("<", "\\u003c")


def _viewer_source() -> str:
    """The viewer as one script; the package is not imported, for it would bring its server along."""
    package = importlib.util.find_spec("meshcat")
    for folder in (package.submodule_search_locations or []) if package is not None else []:
        file = Path(folder) / "viewer" / "dist" / "main.min.js"
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise DoormanError("the page needs meshcat", field="meshcat", allowed=how_to_install("viz"))
