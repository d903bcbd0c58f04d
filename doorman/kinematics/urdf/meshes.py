"""Meshes that a URDF names, all of them in one folder."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from doorman.kinematics.urdf.mesh_paths import mesh_file
from doorman.kinematics.urdf.structure import check_structure

_UNSAFE = re.compile(r"[^\w.-]")
"""What of a mesh's name does not go into the name of a copy."""


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
