"""Meshes of collision shapes, looked at before a library reads them: size, number of vertices, numbers, extent."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

from doorman.arrays import Array
from doorman.bounds import parse_numbers, read_bytes
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.mesh_paths import mesh_file

LARGEST_FILE = 50_000_000
"""Largest file of a mesh [bytes]."""
MOST_VERTICES = 1_000_000
LARGEST_EXTENT = 1000.0
"""Largest distance of a mesh's vertices from its origin, along any axis [m]."""
_HEADER, _COUNT, _FACE = 80, 4, 50
"""Parts of a binary STL file [bytes]."""


def check_meshes(urdf: Path, root: ElementTree.Element) -> None:
    """Check the meshes of a URDF's collision shapes, as far as they exist: a missing one is its reader's error."""
    for link in root.findall("link"):
        for mesh in link.findall("collision/geometry/mesh"):
            name = mesh.get("filename", "")
            file = mesh_file(urdf, name)
            if file is not None:
                scale = np.array(parse_numbers(mesh.get("scale", "1 1 1")))
                _check(file, scale, _Fault(urdf, f"link {link.get('name')}/collision/mesh", name))


class _Fault:
    """Makes errors about one mesh."""

    def __init__(self, urdf: Path, field: str, name: str) -> None:
        self._urdf, self._field, self._name = urdf, field, name

    def __call__(self, what: str, given: object, allowed: str) -> UrdfError:
        return UrdfError(what, file=self._urdf, field=self._field, given=f"{self._name}: {given}", allowed=allowed)


def _check(file: Path, scale: Array, fault: _Fault) -> None:
    size = file.stat().st_size
    if not 0 < size <= LARGEST_FILE:
        raise fault("not a mesh's size", f"{size} bytes", f"1 to {LARGEST_FILE} bytes")
    try:
        vertices = _vertices(file, fault)
    except OSError as error:
        raise fault("a mesh cannot be read", error.strerror, "a readable file") from error
    if vertices is None:
        return
    if not 0 < len(vertices) <= MOST_VERTICES:
        raise fault("not a mesh's number of vertices", len(vertices), f"1 to {MOST_VERTICES}")
    if not np.isfinite(vertices).all():
        raise fault(
            "a vertex is not a number", vertices[~np.isfinite(vertices).all(axis=1)][0].tolist(), "finite numbers"
        )
    extent = float(np.abs(vertices * scale).max())
    if extent > LARGEST_EXTENT:
        raise fault("too large a mesh", f"{extent:g} m", f"up to {LARGEST_EXTENT:g} m from its origin")


def _vertices(file: Path, fault: _Fault) -> Array | None:
    """Vertices of an STL or OBJ file, shape (m, 3), before its scale; None for other formats."""
    if file.suffix.lower() == ".stl":
        return _stl_vertices(read_bytes(file, LARGEST_FILE, UrdfError), fault)
    if file.suffix.lower() == ".obj":
        return _numbers_after(read_bytes(file, LARGEST_FILE, UrdfError), b"v", fault)
    return None


def _stl_vertices(content: bytes, fault: _Fault) -> Array:
    faces = int.from_bytes(content[_HEADER : _HEADER + _COUNT], "little")
    if content[:5] == b"solid" and len(content) != _HEADER + _COUNT + _FACE * faces:
        return _numbers_after(content, b"vertex", fault)
    body = content[_HEADER + _COUNT :]
    if len(body) < _FACE * faces:
        raise fault("a mesh is cut off", f"{len(body) // _FACE} of {faces} faces", "all faces that its head counts")
    rows = np.frombuffer(body, dtype=np.uint8, count=_FACE * faces).reshape(faces, _FACE)
    numbers = np.ascontiguousarray(rows[:, :48]).view("<f4").reshape(faces, 4, 3)
    return numbers[:, 1:].reshape(-1, 3).astype(np.float64)


def _numbers_after(content: bytes, keyword: bytes, fault: _Fault) -> Array:
    """Three numbers of every line that begins with a word."""
    rows = [words[1:4] for words in map(bytes.split, content.splitlines()) if words[:1] == [keyword]]
    try:
        if any(b"_" in word for row in rows for word in row):  # all that float() reads of bytes and C++ does not
            raise ValueError("an underscore")
        return np.array([[float(word) for word in row] for row in rows], dtype=np.float64).reshape(len(rows), 3)
    except ValueError as error:
        raise fault("a vertex is not three numbers", error, "three numbers") from error
