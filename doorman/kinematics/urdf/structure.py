"""Structure of a URDF, checked before a library reads it: libraries skip what they cannot read, or say only "invalid"."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from doorman.bounds import parse_numbers
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.document import parse_document, read_content

ROUNDING = 1e-3
"""By which URDFs round: lengths [m], entries of a rotation, and moments of inertia as a share."""
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_NUMBERS: dict[str, dict[str, int]] = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(_INERTIA, 1),
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"scale": 3},
}
"""How many numbers an attribute holds, by element."""
_REQUIRED = {
    "mass": ("value",),
    "inertia": _INERTIA,
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
}
_POSITIVE = {("box", "size"), ("cylinder", "radius"), ("cylinder", "length"), ("sphere", "radius")}
_NOT_NEGATIVE = {("mass", "value"), ("limit", "effort"), ("dynamics", "damping"), ("dynamics", "friction")}
_CHILDREN = {"inertial": ("mass", "inertia"), "visual": ("geometry",), "collision": ("geometry",)}
LARGEST_LENGTH, _MASS = 1e3, 1e5
"""Largest length [m], and mass [kg] or moment of inertia [kg m²]: ten times a hangar's door."""
_LARGEST = dict.fromkeys(_NUMBERS, 1e6) | dict.fromkeys(("origin", "box", "cylinder", "sphere"), LARGEST_LENGTH)
_LARGEST |= {"mass": _MASS, "inertia": _MASS, "limit": 1e20}
"""Largest numbers of each element; exporters write 1e16 for no limit."""
LOST = 1e-5
"""Length of an axis, size of a mesh [m], and thickness of a hull as a share of its size, below which rounding hides them."""
_SHAPES = ("box", "cylinder", "sphere", "mesh")
_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


def check_structure(path: Path) -> ElementTree.Element:
    """Check that a file is a URDF: well-formed, a tree of links and joints, every number there, finite and in bounds."""
    return copy.deepcopy(_checked(path, read_content(path)))


@lru_cache(maxsize=8)
def _checked(path: Path, content: bytes) -> ElementTree.Element:
    """The checked root of what a file holds: a model and its check ask for the same two files dozens of times."""
    root = parse_document(path, content)
    if root.tag != "robot":
        raise UrdfError("not a URDF", file=path, field="root element", given=root.tag, allowed="<robot>")
    top = f"/robot[{root.get('name')}]"
    if not root.get("name"):
        raise UrdfError("the robot has no name", file=path, field="/robot@name", given="", allowed="a name")
    for element in root:
        if element.tag in ("link", "joint"):
            _check_numbers(path, element, f"{top}/{element.tag}[{element.get('name')}]")
    links = _named(path, root, "link", top)
    joints = _named(path, root, "joint", top)
    for name, joint in joints.items():
        _check_joint(path, joint, f"{top}/joint[{name}]")
    _check_tree(path, top, links, joints)
    return root


def _check_numbers(path: Path, top: ElementTree.Element, where: str) -> None:
    for element, here in _walk(top, where):
        for child in _CHILDREN.get(element.tag, ()):
            if element.find(child) is None:
                raise UrdfError("an element is missing", file=path, field=here, given="none", allowed=f"<{child}>")
        if element.tag == "geometry" and len(element) != 1:
            raise UrdfError("not exactly one shape", file=path, field=here, given=len(element), allowed="one shape")
        if element.tag == "geometry" and element[0].tag not in _SHAPES:
            raise UrdfError(
                "not a valid URDF: no such shape",
                file=path,
                field=here,
                given=element[0].tag,
                allowed=", ".join(_SHAPES),
            )
        for attribute in _REQUIRED.get(element.tag, ()):
            if element.get(attribute) is None:
                field = f"{here}@{attribute}"
                raise UrdfError("an attribute is missing", file=path, field=field, given="none", allowed="a number")
        for attribute, count in _NUMBERS.get(element.tag, {}).items():
            text = element.get(attribute)
            if text is not None:
                _check_text(path, element.tag, attribute, text, count, f"{here}@{attribute}")
                element.set(attribute, " ".join(text.split()))  # urdfdom knows no blanks but single spaces


def _check_text(path: Path, tag: str, attribute: str, text: str, count: int, field: str) -> None:
    try:
        numbers = parse_numbers(text)
    except ValueError:
        numbers = []
    if len(numbers) != count:
        allowed = "a finite number" if count == 1 else f"{count} finite numbers"
        raise UrdfError(f"not {allowed}", file=path, field=field, given=text, allowed=allowed)
    if max(map(abs, numbers)) > _LARGEST[tag]:
        raise UrdfError("too large", file=path, field=field, given=text, allowed=f"up to {_LARGEST[tag]:g}")
    if (tag, attribute) in _POSITIVE and min(numbers) <= 0.0:
        raise UrdfError("not positive", file=path, field=field, given=text, allowed="> 0")
    if (tag, attribute) in _NOT_NEGATIVE and min(numbers) < 0.0:
        raise UrdfError("negative", file=path, field=field, given=text, allowed=">= 0")


def _walk(top: ElementTree.Element, where: str) -> Iterator[tuple[ElementTree.Element, str]]:
    waiting = [(top, where)]
    while waiting:
        element, here = waiting.pop()
        yield element, here
        for child in element:
            name = child.get("name")
            waiting.append((child, f"{here}/{child.tag}[{name}]" if name else f"{here}/{child.tag}"))


def _named(path: Path, root: ElementTree.Element, tag: str, top: str) -> dict[str, ElementTree.Element]:
    found: dict[str, ElementTree.Element] = {}
    for element in root.findall(tag):
        name = element.get("name", "")
        if not name or name in found:
            raise UrdfError(
                f"two {tag}s of one name" if name else f"a {tag} without a name", file=path, field=f"{top}/{tag}@name",
                given=name, allowed="a name of its own",
            )  # fmt: skip
        found[name] = element
    return found


def _check_joint(path: Path, joint: ElementTree.Element, where: str) -> None:
    kind = joint.get("type", "")
    if kind not in _JOINT_TYPES:
        raise UrdfError(
            "no such type of joint", file=path, field=f"{where}@type", given=kind, allowed=", ".join(_JOINT_TYPES)
        )
    axis, limit = joint.find("axis"), joint.find("limit")
    if kind in ("revolute", "continuous", "prismatic", "planar") and axis is not None:
        text = axis.get("xyz", "1 0 0")
        if math.hypot(*parse_numbers(text)) < LOST:  # fixed joints may have one: some exporters write it
            raise UrdfError(
                "an axis without direction", file=path, field=f"{where}/axis@xyz", given=text, allowed="not all zero"
            )
    if kind in ("revolute", "prismatic") and limit is None:
        limit = ElementTree.SubElement(joint, "limit")  # no range: an error of what moves this joint, if anything does
    if limit is not None:
        for attribute in ("effort", "velocity"):  # readers want both; converters write −1 for no limit
            text = limit.get(attribute, "0")
            limit.set(attribute, "0" if float(text) < 0.0 else text)


def _check_tree(
    path: Path, top: str, links: dict[str, ElementTree.Element], joints: dict[str, ElementTree.Element]
) -> None:
    parent_of: dict[str, str] = {}
    for name, joint in joints.items():
        ends = []
        for tag in ("parent", "child"):
            end = joint.find(tag)
            link = "" if end is None else end.get("link", "")
            if link not in links:
                raise UrdfError(
                    "no such link", file=path, field=f"{top}/joint[{name}]/{tag}@link", given=link,
                    allowed=", ".join(links) or "a link; the file has none",
                )  # fmt: skip
            ends.append(link)
        if ends[1] in parent_of:
            raise UrdfError(
                "two joints move the same link", file=path, field=f"{top}/joint[{name}]/child@link", given=ends[1],
                allowed="one joint to a link: the links are a tree",
            )  # fmt: skip
        parent_of[ends[1]] = ends[0]
    roots = [link for link in links if link not in parent_of]
    reached = list(roots)
    for above in reached:
        reached += [link for link, parent in parent_of.items() if parent == above]
    if len(roots) != 1 or len(reached) != len(links):
        raise UrdfError(
            "the links are not one tree", file=path, field=f"{top}/link",
            given=f"roots {', '.join(roots) or 'none'}; {len(links) - len(reached)} links in a loop",
            allowed="one root, every other link the child of a joint",
        )  # fmt: skip
