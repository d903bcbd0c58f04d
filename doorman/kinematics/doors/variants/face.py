"""Another place of a leaf's face: a door's URDF whose leaf stands farther before its hinge axis.

The hinge carries a link without mass, and that carries, by a fixed joint, what the hinge carried. Inertia, shapes and meshes of
the leaf move along.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from doorman.arrays import Array
from doorman.kinematics.doors.variants.variant import write_door_text
from doorman.kinematics.urdf.mesh_paths import mesh_file
from doorman.kinematics.urdf.structure import check_structure

_CARRIER = "carrier_of_"
"""What the new link's name begins with."""


def write_door_with_face(urdf: Path, hinge: str, shift: Array) -> Path:
    """Write a door's URDF with its leaf elsewhere on the hinge, once for each, where `write_door_text` puts it."""
    robot = check_structure(urdf)
    for mesh in robot.iter("mesh"):
        file = mesh_file(urdf, mesh.get("filename", ""))
        mesh.set("filename", mesh.get("filename", "") if file is None else str(file))
    joint = next(joint for joint in robot.findall("joint") if joint.get("name") == hinge)
    child = joint.find("child")
    assert child is not None, "check_structure has seen it"
    carried = str(child.get("link"))
    names = {element.get("name") for element in robot}
    carrier = next(name for n in range(len(names) + 1) if (name := f"{_CARRIER}{carried}{'_' * n}") not in names)
    child.set("link", carrier)
    ElementTree.SubElement(robot, "link", name=carrier)
    fixed = ElementTree.SubElement(robot, "joint", name=f"{carrier}_joint", type="fixed")
    ElementTree.SubElement(fixed, "origin", xyz=" ".join(f"{value:.17g}" for value in shift), rpy="0 0 0")
    ElementTree.SubElement(fixed, "parent", link=carrier)
    ElementTree.SubElement(fixed, "child", link=carried)
    return write_door_text(urdf.stem, ElementTree.tostring(robot, encoding="utf-8"))
