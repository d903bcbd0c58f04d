"""Finding about meshes of a door that are hollow where the doorway is: as convex hulls they close it.

Lines along the way of a vehicle that goes in tell a hull from its mesh: where the hull is in the way and the mesh is not, it
alone closes the doorway.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.feasibility.report import Finding, found, warning_if
from doorman.kinematics.doors.door import Door
from doorman.kinematics.urdf.elements import UrdfShape, read_collisions
from doorman.kinematics.urdf.mesh_hull import convex_hull, mesh_triangles, mesh_vertices
from doorman.kinematics.urdf.structure import ROUNDING
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


def _depths(triangles: Array, along: float, up: float) -> Array:
    """Where a line along `into` passes a surface in the doorway, in order [m]; triangles are of shape (k, 3, 3)."""
    flat = triangles[:, :, 1:] - [along, up]
    near = np.flatnonzero((flat.min(axis=1) <= 0.0).all(axis=1) & (flat.max(axis=1) >= 0.0).all(axis=1))
    a, b, c = flat[near].swapaxes(0, 1)
    parts = np.column_stack([_cross(b, c), _cross(c, a), _cross(a, b)])
    meets = (parts > 0.0).all(axis=1) | (parts < 0.0).all(axis=1)
    weights = parts[meets] / parts[meets].sum(axis=1, keepdims=True)
    return np.sort((weights * triangles[near[meets], :, 0]).sum(axis=1))


def hollow_findings(model: Model) -> list[Finding]:
    """Whether the hulls of the door's meshes leave the doorway open where the meshes do; nothing without such meshes."""
    door = model.door
    return [
        _finding(model, shape)
        for shape in read_collisions(door.urdf)
        if shape.kind == "mesh" and door.links[shape.link].joint == 0 and shape.link != door.section.leaf
    ]


def _finding(model: Model, shape: UrdfShape) -> Finding:
    door, lines = model.door, list(_lines(model))
    in_doorway, hull = _placement(door, shape), convex_hull(door.urdf, shape)
    convex = _moved(in_doorway, hull.vertices)[hull.triangles]
    parts = [_part(convex, *line) for line in lines]
    mesh = convex
    if any(parts):
        mesh = _moved(in_doorway, mesh_vertices(door.urdf, shape))[mesh_triangles(door.urdf, shape)]
    closed = np.array([part is not None and not _fills(mesh, *line[:2], *part)
                       for line, part in zip(lines, parts, strict=True)])  # fmt: skip
    share, advice = float(closed.mean()), ""
    verb = "closes the doorway: it is" if closed.any() else "is"
    if closed.any():
        along, up = lines[int(np.flatnonzero(closed)[-1])][:2]
        boxes = _boxes(mesh, along, up, shape.placement @ np.linalg.inv(in_doorway))
        advice = (
            f"collision shapes are convex: write these lines in link '{shape.link}' instead of the mesh, {' '.join(boxes)}, "
            "or split it into convex meshes"
        )
    return found(
        f"hull of {shape.name}", not closed.any(),
        f"the convex hull of mesh '{shape.file}' of link '{shape.link}' {verb} in the way of {closed.sum()} of {len(lines)} "
        "lines that the mesh leaves free",
        share, 0.0, "", advice, warning_if(not closed[0] and share < _MUCH),
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


def _part(hull: Array, along: float, up: float, nearest: float, farthest: float) -> tuple[float, float] | None:
    """Part of a line that a hull takes, from and to [m]."""
    depths = _depths(hull, along, up)
    if len(depths) < 2:
        return None
    first, last = max(float(depths[0]), nearest), min(float(depths[-1]), farthest)
    return (first, last) if last - first > _THIN else None


def _fills(mesh: Array, along: float, up: float, nearest: float, farthest: float) -> bool:
    """Whether a part of a line is not free: the surface crosses it, or it begins inside."""
    depths = _depths(mesh, along, up)
    return bool((depths < nearest).sum() % 2 or ((depths >= nearest) & (depths <= farthest)).any())


def _boxes(mesh: Array, along: float, up: float, link: Array) -> list[str]:
    """What is beside, above and below a free line, as boxes of a link; `link`: from the doorway to it, shape (4, 4)."""
    (back, left, bottom), (front, right, top) = mesh.min(axis=(0, 1)).tolist(), mesh.max(axis=(0, 1)).tolist()
    inner_left, inner_right = (_edge(mesh, (along, up), (end, up))[0] for end in (left, right))
    inner_bottom, inner_top = (_edge(mesh, (along, up), (along, end))[1] for end in (bottom, top))
    sides = [
        (left, inner_left, bottom, top), (inner_right, right, bottom, top),
        (inner_left, inner_right, inner_top, top), (inner_left, inner_right, bottom, inner_bottom),
    ]  # fmt: skip
    boxes = []
    for a, b, low, high in sides:
        corners = np.array([[back, a, low], [front, b, high]])
        size = corners[1] - corners[0]
        if size.min() > _THIN:
            boxes.append(_box(link, corners.mean(axis=0), size))
    return boxes


def _edge(mesh: Array, free: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    """Where the mesh begins on the way from a free line to the mesh's end, along and up [m]."""
    inside, outside = np.array(free), np.array(end)
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        inside, outside = (inside, middle) if len(_depths(mesh, *middle)) else (middle, outside)
    along, up = (0.5 * (inside + outside)).round(3).tolist()
    return along, up


def _box(link: Array, center: Array, size: Array) -> str:
    """A box of the doorway, ready for a link of a URDF."""
    rotation, place = link[:3, :3], _moved(link, center)
    if (np.minimum(np.abs(rotation), np.abs(1.0 - np.abs(rotation))) < ROUNDING).all():
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
