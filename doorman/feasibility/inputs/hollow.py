"""Finding about meshes of a door that are hollow where the doorway is: as convex hulls they close it.

Lines along the way of a vehicle that goes in tell a hull from its mesh: where the hull is in the way and the mesh is not, it
alone closes the doorway.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.feasibility.report import Finding, Severity
from doorman.kinematics.doors.door import Door
from doorman.kinematics.urdf.mesh_hull import convex_hull, mesh_triangles, mesh_vertices
from doorman.kinematics.urdf.shapes import UrdfShape, read_collisions
from doorman.model import Model

_INNER = np.linspace(0.1493, 0.8507, 5)
"""Where lines pass the doorway, as shares of its sides; none meets an edge that a drawing would have."""
_MUCH = 0.5
"""Share of the lines from which on a hull closes the doorway wherever the tip touches the leaf."""
_NEAR = 0.3
"""Before and behind the face of the closed leaf, where the doorway is [m]."""
_THIN = 0.01
"""Depth of a hull that is in no vehicle's way [m]."""
_HALVINGS = 12
"""Halvings in the search for an edge: to 1 mm of 4 m."""
_ALIGNED = 1e-3
"""Deviation of a rotation matrix from 0 and 1 up to which a box needs no rotation."""


@dataclass(frozen=True, eq=False)
class _Solid:
    """A mesh or its hull, in the doorway: along `into`, `along` and `up` from P_h."""

    triangles: Array  # shape (k, 3, 3) [m]

    def depths(self, along: float, up: float) -> Array:
        """Where a line along `into` passes the surface, in order [m]."""
        flat = self.triangles[:, :, 1:] - [along, up]
        near = np.flatnonzero((flat.min(axis=1) <= 0.0).all(axis=1) & (flat.max(axis=1) >= 0.0).all(axis=1))
        a, b, c = flat[near].swapaxes(0, 1)
        parts = np.column_stack([_cross(b, c), _cross(c, a), _cross(a, b)])
        meets = (parts > 0.0).all(axis=1) | (parts < 0.0).all(axis=1)
        weights = parts[meets] / parts[meets].sum(axis=1, keepdims=True)
        return np.sort((weights * self.triangles[near[meets], :, 0]).sum(axis=1))

    def fills(self, along: float, up: float, nearest: float, farthest: float) -> bool:
        """Whether a part of a line is not free: the surface crosses it, or it begins inside."""
        depths = self.depths(along, up)
        return bool((depths < nearest).sum() % 2 or ((depths >= nearest) & (depths <= farthest)).any())


def hollow_findings(model: Model) -> list[Finding]:
    """Whether the hulls of the door's meshes leave the doorway open where the meshes do; nothing without such meshes."""
    door = model.door
    shapes = [
        shape
        for shape in read_collisions(door.urdf)
        if shape.kind == "mesh" and door.links[shape.link].joint == 0 and shape.link != door.section.leaf
    ]
    return [_finding(model, shape) for shape in shapes]


def _finding(model: Model, shape: UrdfShape) -> Finding:
    door = model.door
    in_doorway = _placement(door, shape)
    hull = convex_hull(door.urdf, shape)
    solid = _Solid(_moved(in_doorway, hull.vertices)[hull.triangles])
    lines = list(_lines(model))
    parts = [_part(solid, *line) for line in lines]
    closed = np.array([part is not None for part in parts])
    mesh = solid
    if closed.any():
        mesh = _Solid(_moved(in_doorway, mesh_vertices(door.urdf, shape))[mesh_triangles(door.urdf, shape)])
        filled = [part is not None and mesh.fills(*line[:2], *part) for line, part in zip(lines, parts, strict=True)]
        closed &= ~np.array(filled)
    share, what = float(closed.mean()), f"mesh '{shape.file}' of link '{shape.link}'"
    if not closed.any():
        message = f"the convex hull of {what} is in the way of 0 of {len(lines)} lines that the mesh leaves free"
        return Finding(f"hull of {shape.name}", Severity.OK, message, 0.0, 0.0, "")
    along, up = lines[int(np.flatnonzero(closed)[-1])][:2]
    boxes = _boxes(mesh, along, up, shape.placement @ np.linalg.inv(in_doorway))
    return Finding(
        f"hull of {shape.name}", Severity.ERROR if closed[0] or share >= _MUCH else Severity.WARNING,
        f"the convex hull of {what} closes the doorway: it is in the way of {closed.sum()} of {len(lines)} lines that the mesh "
        "leaves free", share, 0.0, "",
        f"collision shapes are convex: write these lines in link '{shape.link}' instead of the mesh, {' '.join(boxes)}, "
        "or split it into convex meshes",
    )  # fmt: skip


def _moved(placement: Array, points: Array) -> Array:
    return np.asarray(points @ placement[:3, :3].T + placement[:3, 3])


def _placement(door: Door, shape: UrdfShape) -> Array:
    """Placement of a shape of the frame in the doorway, homogeneous, shape (4, 4)."""
    link = door.link_placements(0.5 * math.pi)[shape.link]
    doorway = np.eye(4)
    doorway[:3, :3], doorway[:3, 3] = door.axes, -door.axes @ door.hinge_position
    return np.asarray(doorway @ link @ shape.placement)


def _lines(model: Model) -> Iterator[tuple[float, float, float, float]]:
    """Lines along `into` at (along, up), and the part of each that the task needs free, from and to [m]."""
    # The first leads to the contact point. A vehicle that stays before the wall needs no other.
    door, at = model.door, (model.coupling.distance_from_hinge, model.coupling.height)
    before = model.stays_before or door.side == "pull"
    for (along, up), offset in ((at, door.contact_offset), *(((a * door.width, u * door.height), door.surface_offset)
                                                            for a in _INNER for u in _INNER if not before)):  # fmt: skip
        yield along, up, -offset - _NEAR, -offset - _THIN if before else -offset + _NEAR


def _part(hull: _Solid, along: float, up: float, nearest: float, farthest: float) -> tuple[float, float] | None:
    """Part of a line that a hull takes, from and to [m]."""
    depths = hull.depths(along, up)
    if len(depths) < 2:
        return None
    first, last = max(float(depths[0]), nearest), min(float(depths[-1]), farthest)
    return (first, last) if last - first > _THIN else None


def _boxes(mesh: _Solid, along: float, up: float, link: Array) -> list[str]:
    """What is beside, above and below a free line, as boxes of a link; `link`: from the doorway to it, shape (4, 4)."""
    lowest, highest = mesh.triangles.min(axis=(0, 1)), mesh.triangles.max(axis=(0, 1))
    (_, left, bottom), (_, right, top) = lowest.tolist(), highest.tolist()
    inner_left, inner_right = (_edge(mesh, (along, up), (end, up)) for end in (left, right))
    inner_bottom, inner_top = (_edge(mesh, (along, up), (along, end)) for end in (bottom, top))
    sides = [
        (left, inner_left[0], bottom, top), (inner_right[0], right, bottom, top),
        (inner_left[0], inner_right[0], inner_top[1], top), (inner_left[0], inner_right[0], bottom, inner_bottom[1]),
    ]  # fmt: skip
    found = []
    for a, b, low, high in sides:
        size = np.array([highest[0] - lowest[0], b - a, high - low])
        if size.min() > _THIN:
            center = np.array([0.5 * (lowest[0] + highest[0]), 0.5 * (a + b), 0.5 * (low + high)])
            found.append(_box(link, center, size))
    return found


def _edge(mesh: _Solid, free: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    """Where the mesh begins on the way from a free line to the mesh's end, along and up [m]."""
    inside, outside = np.array(free), np.array(end)
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        inside, outside = (inside, middle) if len(mesh.depths(*middle)) else (middle, outside)
    along, up = (0.5 * (inside + outside)).round(3).tolist()
    return along, up


def _box(link: Array, center: Array, size: Array) -> str:
    """A box of the doorway, ready for a link of a URDF."""
    rotation, place = link[:3, :3], _moved(link, center)
    if (np.minimum(np.abs(rotation), np.abs(1.0 - np.abs(rotation))) < _ALIGNED).all():
        size, turn = np.abs(rotation) @ size, ""
    else:
        rotation = rotation * [1.0, 1.0, np.linalg.det(rotation)]  # the doorway's axes may be left-handed
        turn = f' rpy="{_numbers(pinocchio.rpy.matrixToRpy(rotation))}"'
    box = f'<geometry><box size="{_numbers(size)}"/></geometry>'
    return f'<collision><origin xyz="{_numbers(place)}"{turn}/>{box}</collision>'


def _numbers(values: Array) -> str:
    return " ".join(f"{round(float(value), 3) + 0.0:g}" for value in values)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
