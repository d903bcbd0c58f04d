"""Another door of the same make: its URDF with another width or mass of the leaf, or another place of its face.

The world is cut along the middle of the closed leaf, and the difference in width is put in between: boxes that span the cut
grow by it, whatever lies beyond it moves by it. The leaf's inertial is spread with its width and scaled with its mass, so
that a thin plate stays one. For another face the hinge carries a link without mass, and that carries, by a fixed joint, what the
hinge carried: inertia, shapes and meshes of the leaf move along.
"""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ElementTree
from functools import cache
from pathlib import Path

import numpy as np

from doorman.arrays import Array
from doorman.bounds import parse_numbers
from doorman.compilation import cache_directory
from doorman.compilation.cache_files import write_atomically
from doorman.compilation.cache_place import fresh_directory
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import placement_of
from doorman.kinematics.urdf.mesh_files import mesh_file
from doorman.kinematics.urdf.structure import check_structure

_CARRIER = "carrier_of_"
"""What the new link's name begins with."""
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def write_door_variant(
    urdf: Path, leaf: str, hinge: Array, along_leaf: Array, along_frame: Array, width: float, new_width: float | None,
    new_mass: float | None,
) -> Path:  # fmt: skip
    """Write a door's URDF with another leaf, once for each, to the cache on disk, or to a temporary file if that is full."""
    robot = check_structure(urdf)
    frame, slab = _frame_and_leaf(robot, leaf, urdf)
    if new_width is not None:
        of_leaf, of_frame = (_axis(urdf, along) for along in (along_leaf, along_frame))
        _stretch(slab, *of_leaf, width / 2, new_width - width)
        _stretch(frame, *of_frame, of_frame[1] * float(hinge[of_frame[0]]) + width / 2, new_width - width)
    ratio = 1.0 if new_width is None else new_width / width
    _spread_inertial(slab, 1.0 + (ratio - 1.0) * np.abs(along_leaf), new_mass)
    return write_door_text(urdf.stem, ElementTree.tostring(robot, encoding="utf-8"))


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


def write_door_text(stem: str, text: bytes) -> Path:
    """Write the URDF of a door that was made of another one to the cache on disk, or to a temporary file if that is full."""
    name = f"{stem}-{hashlib.sha256(text).hexdigest()[:16]}.urdf"
    try:
        return _written(cache_directory() / "doors" / name, text)
    except OSError:
        return _written(_temporary_directory() / name, text)


def _written(path: Path, text: bytes) -> Path:
    """A file with this text, written if it is not there as a whole."""
    if not path.is_file() or path.read_bytes() != text:
        write_atomically(path, text)
    return path


@cache
def _temporary_directory() -> Path:
    return fresh_directory()


def _frame_and_leaf(
    robot: ElementTree.Element, leaf: str, urdf: Path
) -> tuple[ElementTree.Element, ElementTree.Element]:
    links = {link.get("name"): link for link in robot.findall("link")}
    slab = links.pop(leaf, None)
    if slab is None or len(links) != 1:
        raise UrdfError(
            "only a door of two links can be given another leaf", file=urdf, field="door.width, door.mass",
            given=", ".join(str(name) for name in links), allowed=f"a frame and '{leaf}'",
        )  # fmt: skip
    if robot.find(".//mesh") is not None:
        raise UrdfError(
            "a door with meshes cannot be given another leaf", file=urdf, field="door.width, door.mass",
            allowed="boxes, cylinders and spheres",
        )  # fmt: skip
    (frame,) = links.values()
    return frame, slab


def _axis(urdf: Path, along: Array) -> tuple[int, float]:
    """Axis of a link that a direction lies along, and its sign on it."""
    axis = int(np.argmax(np.abs(along)))
    if abs(along[axis]) < 1.0 - 1e-6:
        raise UrdfError(
            "a door at an angle to its links' axes cannot be made wider", file=urdf, field="door.width",
            given=f"a leaf along {along.round(3).tolist()}", allowed="one along x or y of frame and leaf",
        )  # fmt: skip
    return axis, float(np.sign(along[axis]))


def _stretch(link: ElementTree.Element, axis: int, sign: float, cut: float, difference: float) -> None:
    """Insert a difference in length at a cut across an axis of the link, both measured along its `sign`."""
    for shape in [*link.findall("visual"), *link.findall("collision")]:
        placed = placement_of(shape)
        center, rotation = placed[:3, 3], placed[:3, :3]
        box = shape.find("geometry/box")
        size = np.zeros(3) if box is None else np.array(parse_numbers(box.get("size", "")))
        edge = int(np.argmax(np.abs(rotation[axis])))
        middle = sign * center[axis]
        if middle - size[edge] / 2 < cut < middle + size[edge] / 2 and box is not None:
            center[axis] += sign * difference / 2
            size[edge] += difference
            box.set("size", _text(size))
        elif middle > cut:
            center[axis] += sign * difference
        _origin(shape).set("xyz", _text(center))


def _spread_inertial(link: ElementTree.Element, ratios: Array, new_mass: float | None) -> None:
    """Spread the leaf's mass along the link's axes by ratios, (3,), and scale it to another mass."""
    inertial = link.find("inertial")
    mass = None if inertial is None else inertial.find("mass")
    inertia = None if inertial is None else inertial.find("inertia")
    if inertial is None or mass is None or inertia is None:
        return  # a leaf without mass is refused when the door is read
    placed = placement_of(inertial)
    center, rotation = placed[:3, 3], placed[:3, :3]
    upper, matrix = np.triu_indices(3), np.zeros((3, 3))
    matrix[upper] = matrix.T[upper] = [float(inertia.get(name, "0")) for name in _INERTIA]
    matrix = rotation @ matrix @ rotation.T
    spread = np.diag(ratios)
    second_moments = spread @ (np.trace(matrix) / 2 * np.eye(3) - matrix) @ spread
    old_mass = float(mass.get("value", "0"))
    scale = 1.0 if new_mass is None or old_mass == 0.0 else new_mass / old_mass
    new = scale * (np.trace(second_moments) * np.eye(3) - second_moments)
    for name, value in zip(_INERTIA, new[upper], strict=True):
        inertia.set(name, _text([value]))
    mass.set("value", _text([scale * old_mass]))
    origin = _origin(inertial)
    origin.set("xyz", _text(spread @ center))
    origin.set("rpy", "0 0 0")


def _origin(element: ElementTree.Element) -> ElementTree.Element:
    origin = element.find("origin")
    return ElementTree.SubElement(element, "origin", xyz="0 0 0", rpy="0 0 0") if origin is None else origin


def _text(numbers: Array | list[float]) -> str:
    return " ".join(f"{number:.17g}" for number in numbers)
