"""Paths of the meshes that a URDF names, the same for every library."""

from __future__ import annotations

from pathlib import Path

from doorman.exceptions import UrdfError

_FILE, _PACKAGE = "file://", "package://"


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
