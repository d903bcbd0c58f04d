"""Meshes that a URDF names: where their files are, the same for every library, and copies of them in one folder."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from doorman.bounds import read_bytes
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.document import read_content
from doorman.kinematics.urdf.structure import check_structure

LARGEST_FILE = 50_000_000
"""Largest file of a mesh that is copied [bytes]."""
_FILE, _PACKAGE = "file://", "package://"
_UNSAFE = re.compile(r"[^\w.-]")
"""What of a mesh's name does not go into the name of a copy."""


def mesh_path(urdf: Path, filename: str, field: str) -> Path:
    """Path of a mesh's file."""
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


def mesh_file(urdf: Path, name: str) -> Path | None:
    """File of a mesh, if there is one."""
    try:
        path = mesh_path(urdf, name, "mesh")
    except UrdfError:
        return None
    return path if path.is_file() else None


def portable_files(urdf: Path, name: str) -> dict[str, bytes]:
    """A URDF and its meshes as files that belong into one folder, wherever that is.

    A mesh that does not exist stays named as it is. Without meshes, the URDF stays what it is to the byte.
    """
    root = check_structure(urdf)
    copies: dict[Path, str] = {}
    for mesh in root.iter("mesh"):
        file = mesh_file(urdf, mesh.get("filename", ""))
        if file is not None:
            copies.setdefault(file, f"{name}-{len(copies)}-{_UNSAFE.sub('_', file.name)}")
            mesh.set("filename", copies[file])
    text = ElementTree.tostring(root, encoding="utf-8") if copies else read_content(urdf)
    return {f"{name}.urdf": text, **{copy: read_bytes(file, LARGEST_FILE, UrdfError) for file, copy in copies.items()}}
