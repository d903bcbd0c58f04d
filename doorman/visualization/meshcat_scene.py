"""Scene in meshcat's commands: shapes, their motion and a trace, as plain data for the viewer in the page."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.visualization.shapes import VisualShape

Array = NDArray[np.float64]
Command = dict[str, Any]

FRAMES_PER_SECOND = 30
_HOLD = 1.5
"""The last frame stays this long before the replay starts again [s]."""
_TRACE_RADIUS = 0.006
_TRACE_SIDES = 6
_TRACE_SPACING = 0.01
_TRACE_COLOR = (0.84, 0.37, 0.0, 1.0)
_Y_TO_Z = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


class Scene:
    """Collects meshcat's commands, and the tracks of what moves.

    Args:
        frames: Number of frames of every track.
    """

    def __init__(self, frames: int) -> None:
        self.commands: list[Command] = []
        self._times = [*range(frames), frames - 1 + int(_HOLD * FRAMES_PER_SECOND)]
        self._animations: list[Command] = []

    def add(self, path: str, shape: VisualShape) -> None:
        """Show a shape."""
        self.commands.append(_set_object(path, _geometry(shape), shape.color))
        turn = _Y_TO_Z if shape.kind == "cylinder" else np.eye(4)  # the viewer's cylinders stand along y
        self.commands.append(_set_transform(path, shape.placement @ turn))

    def move(self, path: str, placements: Array) -> None:
        """Give a node a placement, shape (m, 4, 4), at every frame; one only if it does not move."""
        if np.allclose(placements, placements[0], rtol=0.0, atol=1e-9):
            self.commands.append(_set_transform(path, placements[0]))
            return
        quaternions = np.array([pinocchio.Quaternion(placement[:3, :3]).coeffs() for placement in placements])
        tracks = [
            self._track("position", "vector3", placements[:, :3, 3]),
            self._track("quaternion", "quaternion", quaternions),
        ]
        self._animations.append({"path": path, "clip": {"fps": FRAMES_PER_SECOND, "name": "replay", "tracks": tracks}})

    def trace(self, path: str, points: Array) -> list[int]:
        """Show a tube through the points; how many of its indices to draw at each frame, empty if it has no length."""
        lengths = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()])
        segments = int(lengths[-1] / _TRACE_SPACING)
        if segments < 1:
            return []
        along = np.linspace(0.0, lengths[-1], segments + 1)
        corners = np.column_stack([np.interp(along, lengths, column) for column in points.T])
        geometry = {
            "type": "TubeGeometry",
            "path": {"type": "CatmullRomCurve3", "points": corners.round(4).tolist(), "closed": False,
                     "curveType": "centripetal", "tension": 0.5, "arcLengthDivisions": 2 * segments},
            "tubularSegments": segments,
            "radius": _TRACE_RADIUS,
            "radialSegments": _TRACE_SIDES,
            "closed": False,
        }  # fmt: skip
        self.commands.append(_set_object(path, geometry, _TRACE_COLOR))
        drawn = np.floor(lengths / lengths[-1] * segments).astype(int) * _TRACE_SIDES * 6  # two triangles a side
        return [int(count) for count in drawn]

    def animation(self) -> Command:
        """The command that starts all tracks, over and over."""
        options = {"play": True, "repetitions": 1_000_000}
        return {"type": "set_animation", "animations": self._animations, "options": options, "path": ""}

    def _track(self, name: str, kind: str, values: Array) -> Command:
        held = np.vstack([values, values[-1:]])
        return {"name": f".{name}", "type": kind, "times": self._times, "values": held.round(5).ravel().tolist()}


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


def _set_transform(path: str, placement: Array) -> Command:
    return {"type": "set_transform", "path": path, "matrix": placement.T.ravel().round(6).tolist()}


def set_property(path: str, name: str, value: Any) -> Command:
    """The command that sets a property of a node."""
    return {"type": "set_property", "path": path, "property": name, "value": value}
