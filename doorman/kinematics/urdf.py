"""Reading a URDF: one place where a broken file becomes a clear error."""

from __future__ import annotations

import logging
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pinocchio
import yourdfpy
from numpy.typing import NDArray

from doorman.exceptions import UrdfError

_NUMERIC_ATTRIBUTES = ("xyz", "rpy", "value", "size", "radius", "length", "lower", "upper", "effort", "velocity", "damping",
                       "friction", "ixx", "ixy", "ixz", "iyy", "iyz", "izz")  # fmt: skip


def load_pinocchio(path: Path) -> pinocchio.Model:
    """Kinematic tree of a URDF whose root link is fixed in the world.

    Args:
        path: URDF file.

    Returns:
        Pinocchio's model.

    Raises:
        UrdfError: if the file is missing, is not XML, is not a URDF, or holds a value that is not a finite number.
    """
    _check_xml(path)
    try:
        return pinocchio.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        raise UrdfError(f"not a valid URDF: {_one_line(error)}", file=path) from error


def load_description(path: Path) -> yourdfpy.URDF:
    """Links, joints and primitive shapes of a URDF as written, without meshes.

    Args:
        path: URDF file.

    Returns:
        yourdfpy's model, without a scene.

    Raises:
        UrdfError: if the file is missing, is not XML, or is not a URDF.
    """
    _check_xml(path)
    logging.getLogger("yourdfpy").setLevel(logging.ERROR)
    try:
        return yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=False)
    except Exception as error:  # yourdfpy raises whatever its parser stumbles over
        raise UrdfError(f"not a valid URDF: {_one_line(error)}", file=path) from error


def frame_index(model: pinocchio.Model, name: str, path: Path, field: str) -> int:
    """Index of a frame that must exist.

    Raises:
        UrdfError: if the URDF has no link or joint of that name; the error lists the ones it has.
    """
    if not model.existFrame(name):
        names = ", ".join(frame.name for frame in model.frames if frame.name != "universe")
        raise UrdfError(f"the URDF has no link or joint '{name}'", file=path, field=field, given=name, allowed=names)
    body = pinocchio.FrameType.BODY  # a joint may carry the same name as its link
    return int(model.getFrameId(name, body) if model.existFrame(name, body) else model.getFrameId(name))


def frozen(values: object) -> NDArray[np.float64]:
    """Read-only float array with the values of `values`."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _check_xml(path: Path) -> None:
    if not path.is_file():
        raise UrdfError("no such URDF file", file=path)
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, UnicodeDecodeError) as error:
        raise UrdfError(f"not well-formed XML: {error}", file=path) from error
    if root.tag != "robot":
        raise UrdfError("not a URDF", file=path, field="root element", given=root.tag, allowed="<robot>")
    for element, where in _walk(root, ""):
        for attribute in _NUMERIC_ATTRIBUTES:
            text = element.get(attribute)
            if text is not None and element.tag != "axis" and not _is_finite(text):
                field = f"{where}@{attribute}"
                raise UrdfError("not a finite number", file=path, field=field, given=text, allowed="finite numbers")


def _walk(element: ElementTree.Element, where: str) -> list[tuple[ElementTree.Element, str]]:
    name = element.get("name")
    here = f"{where}/{element.tag}[{name}]" if name else f"{where}/{element.tag}"
    found = [(element, here)]
    for child in element:
        if isinstance(child.tag, str):
            found.extend(_walk(child, here))
    return found


def _is_finite(text: str) -> bool:
    try:
        return all(math.isfinite(float(word)) for word in text.split())
    except ValueError:
        return False


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
