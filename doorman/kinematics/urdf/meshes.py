"""Meshes that a URDF names, all of them in one folder."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from doorman.bounds import read_bytes
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.document import read_content
from doorman.kinematics.urdf.mesh_checks import LARGEST_FILE
from doorman.kinematics.urdf.mesh_paths import mesh_file
from doorman.kinematics.urdf.structure import check_structure

_UNSAFE = re.compile(r"[^\w.-]")
"""What of a mesh's name does not go into the name of a copy."""


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
