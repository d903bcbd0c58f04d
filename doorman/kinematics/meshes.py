"""Meshes that a URDF names: where their files are, whatever library reads them, and all of them in one folder."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from doorman.exceptions import UrdfError
from doorman.kinematics.urdf_structure import check_structure

_UNSAFE = re.compile(r"[^\w.-]")
"""What of a mesh's name does not go into the name of a copy."""
_FILE, _PACKAGE = "file://", "package://"


def mesh_path(urdf: Path, filename: str, field: str) -> Path:
    """Path of a mesh's file.

    Args:
        urdf: URDF that names it.
        filename: `package://NAME/path` is NAME/path in the nearest folder above the URDF that has it; anything else is relative
            to the URDF's folder, or absolute with or without `file://`.
        field: Element that names it, for the error.

    Returns:
        An absolute path; where there is no such file, the one that is missing.

    Raises:
        UrdfError: if it is another kind of address.
    """
    folders = urdf.resolve().parents
    if filename.startswith(_PACKAGE):
        relative = filename.removeprefix(_PACKAGE)
        return next((folder / relative for folder in folders if (folder / relative).is_file()), folders[0] / relative)
    path = filename.removeprefix(_FILE)
    if "://" in path:
        raise UrdfError(
            "meshes are read from files", file=urdf, field=field, given=filename,
            allowed="a path relative to the URDF, file:///path, or package://NAME/path",
        )  # fmt: skip
    return folders[0] / path


def with_mesh_paths(urdf: Path) -> str:
    """A URDF as text whose collision meshes are absolute paths: libraries differ in how they look for others.

    Args:
        urdf: URDF file.

    Returns:
        XML.

    Raises:
        UrdfError: if the file is no URDF, or a mesh is no file.
    """
    robot = check_structure(urdf)
    for mesh, path in _collision_meshes(robot, urdf):
        mesh.set("filename", str(path))
    return ElementTree.tostring(robot, encoding="unicode")


def missing_meshes(urdf: Path) -> list[str]:
    """Collision meshes that a URDF names and that are no files.

    Args:
        urdf: URDF file.

    Returns:
        Their names as written.

    Raises:
        UrdfError: if the file is no URDF, or a mesh has another kind of address.
    """
    meshes = _collision_meshes(check_structure(urdf), urdf)
    return [mesh.get("filename", "") for mesh, path in meshes if not path.is_file()]


def _collision_meshes(robot: ElementTree.Element, urdf: Path) -> list[tuple[ElementTree.Element, Path]]:
    return [
        (mesh, mesh_path(urdf, mesh.get("filename", ""), f"link {link.get('name')}/collision"))
        for link in robot.findall("link")
        for mesh in link.iterfind("collision/geometry/mesh")
    ]


def mesh_file(urdf: Path, name: str) -> Path | None:
    """File of a mesh, if there is one.

    Args:
        urdf: File that names the mesh.
        name: As written there; see `mesh_path`.

    Returns:
        The file; None if there is none.
    """
    try:
        path = mesh_path(urdf, name, "mesh")
    except UrdfError:
        return None
    return path if path.is_file() else None


def portable_files(urdf: Path, name: str) -> dict[str, bytes]:
    """A URDF and its meshes as files that belong into one folder, wherever that is.

    A mesh that does not exist stays named as it is. Without meshes, the URDF stays what it is to the byte.

    Args:
        urdf: The file.
        name: Of the copy, without suffix; names of the meshes begin with it too.

    Returns:
        Contents by file name; the URDF first.

    Raises:
        UrdfError: if the URDF cannot be read.
        OSError: if a mesh cannot be read.
    """
    root = check_structure(urdf)
    copies: dict[Path, str] = {}
    for mesh in root.iter("mesh"):
        file = mesh_file(urdf, mesh.get("filename", ""))
        if file is not None:
            copies.setdefault(file, f"{name}-{len(copies)}-{_UNSAFE.sub('_', file.name)}")
            mesh.set("filename", copies[file])
    text = ElementTree.tostring(root, encoding="utf-8") if copies else urdf.read_bytes()
    return {f"{name}.urdf": text, **{copy: file.read_bytes() for file, copy in copies.items()}}
