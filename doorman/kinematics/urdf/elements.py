"""What a URDF says that Pinocchio does not keep: its joints' effort, torques and leaders.

Read from the XML itself, in a fraction of a millisecond: parsers of whole URDFs take half a second to import.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from doorman.bounds import parse_numbers
from doorman.kinematics.urdf.structure import check_structure


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as written, of any type."""

    name: str
    kind: str
    """`revolute`, `prismatic`, `fixed` and so on."""
    child: str
    """Link that it carries."""
    parent: str
    """Link that it hangs on."""
    axis: tuple[float, float, float]
    """In the child's frame at rest."""
    effort: float
    """`<limit effort>`, 0 without limits [N m] or [N]."""
    limited: bool
    """Whether `<limit>` is written."""
    damping: float
    """`<dynamics damping>`, 0 by default [N m s/rad]."""
    friction: float
    """`<dynamics friction>`, 0 by default [N m]."""
    leader: str | None
    """Joint that it follows by `<mimic>`."""


def read_joints(path: Path) -> dict[str, UrdfJoint]:
    """Joints of a URDF by name, in the order of the file."""
    return {joint.name: joint for joint in map(_joint, check_structure(path).findall("joint"))}


def _joint(element: ElementTree.Element) -> UrdfJoint:
    mimic = element.find("mimic")
    x, y, z = _numbers(element, "axis", "xyz", "1 0 0")
    return UrdfJoint(
        name=element.get("name", ""),
        kind=element.get("type", ""),
        child=_text(element, "child", "link", ""),
        parent=_text(element, "parent", "link", ""),
        axis=(x, y, z),
        effort=_numbers(element, "limit", "effort", "0")[0],
        limited=element.find("limit") is not None,
        damping=_numbers(element, "dynamics", "damping", "0")[0],
        friction=_numbers(element, "dynamics", "friction", "0")[0],
        leader=None if mimic is None else mimic.get("joint", ""),
    )


def _numbers(element: ElementTree.Element, tag: str, attribute: str, default: str) -> list[float]:
    """Numbers of a child's attribute; the structure's check has seen that they are there and finite."""
    return parse_numbers(_text(element, tag, attribute, default))


def _text(element: ElementTree.Element, tag: str, attribute: str, default: str) -> str:
    child = element.find(tag)
    return default if child is None else child.get(attribute, default)
